// OpenVDB files: spheres as a point grid, level sets beside them.
#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/vdb_init.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/vdb_stream.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <openvdb/points/AttributeArrayString.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

namespace points = openvdb::points;
using Leaf = points::PointDataTree::LeafNodeType;
template <typename T>
using Plain = points::TypedAttributeArray<T>;  ///< the null codec: no rounding

/// Leaves per axis that fit a key: 21 bits each.
constexpr double kLeavesPerAxis = 1 << 21;
constexpr double kLeafDim = Leaf::DIM;
/// Voxel coordinates stay well inside 32 bits.
constexpr double kMaxCoordinate = 1 << 30;

/// Voxel and offset of a coordinate in voxels. In double both are exact; the offset is then
/// rounded to what a float holds, 2^-25 of a voxel at most.
struct Placed {
    double voxel;
    float offset;
};
Placed placed(double x) {
    Placed p{};
    p.voxel = std::floor(x + 0.5);
    p.offset = static_cast<float>(x - p.voxel);
    // Offsets lie in [-0.5, 0.5): half a voxel up is the lower face of the next one.
    if (p.offset >= 0.5f) {
        p.offset = -0.5f;
        p.voxel += 1;
    }
    return p;
}

bool survives(const PackView& pack, double voxel) {
    for (std::size_t i = 0; i < pack.size(); ++i)
        for (const double c : pack.position(i)) {
            const double steps = c / voxel * 0x1p25;
            if (std::nearbyint(steps) != steps) return false;
        }
    return true;
}

/// Edge of a voxel in the unit that is written.
double chooseVoxel(const PackView& pack, double wanted) {
    if (pack.size() == 0) return 1;
    const Box<3> bounds = pack.boundsOfCenters();
    double filled = 0;
    double largest = 0;
    for (std::size_t i = 0; i < pack.size(); ++i) {
        const double r = pack.radius(i);
        filled += pack.dim() == 2 ? Measure<2>::ball(r) : Measure<3>::ball(r);
        largest = std::max(largest, r);
    }
    double voxel = 0;
    if (wanted > 0) {
        voxel = std::exp2(std::round(std::log2(fromMillimeters(wanted, pack.unit()))));
    } else {
        // Spheres fill 0.6 of the bone, but which part of the bounds the bone fills is unknown. At
        // least an eighth is assumed: else a pack with most of its spheres removed would get a
        // leaf for each of them.
        const Vec<3> size = bounds.grown(largest).size();
        const double box = pack.dim() == 2 ? size[0] * size[1] : size[0] * size[1] * size[2];
        voxel = pointVoxelSize(static_cast<double>(pack.size()), std::max(filled / 0.6, box / 8),
                               pack.dim());
        // Positions may lie on a lattice that is slightly too fine for such voxels.
        for (const double finer : {voxel, voxel / 2, voxel / 4, voxel / 8})
            if (survives(pack, finer)) {
                voxel = finer;
                break;
            }
    }
    const Vec<3> size = bounds.size();
    double reach = 0;
    double extent = 0;
    for (int d = 0; d < 3; ++d) {
        extent = std::max(extent, size[d]);
        reach = std::max({reach, std::abs(bounds.lo[d]), std::abs(bounds.hi[d])});
    }
    while (voxel < kSmallestVdbVoxel || extent / voxel > kLeafDim * (kLeavesPerAxis - 2) ||
           reach / voxel > kMaxCoordinate)
        voxel *= 2;
    return voxel;
}

/// An attribute of the point grid: its type, and a function that fills the array of a leaf with the
/// values of the listed spheres.
struct PointAttribute {
    std::string name;
    openvdb::NamePair type;
    std::function<void(points::AttributeArray&, const std::vector<std::size_t>&)> fill;
};

template <typename T, typename Get>
PointAttribute attribute(const std::string& name, const Get& get) {
    return {name, Plain<T>::attributeType(),
            [get](points::AttributeArray& array, const std::vector<std::size_t>& spheres) {
                auto& typed = Plain<T>::cast(array);
                typed.expand(false);
                for (openvdb::Index k = 0; k < spheres.size(); ++k)
                    typed.set(k, static_cast<T>(get(spheres[k])));
                // A value that is the same in the whole leaf is stored once.
                typed.compact();
            }};
}

/// Whole numbers as int32 where they fit, as viewers expect, else int64.
template <typename Get>
PointAttribute wholeAttribute(const std::string& name, std::size_t count, const Get& get) {
    bool narrow = true;
    for (std::size_t i = 0; i < count && narrow; ++i) {
        const std::int64_t value = get(i);
        narrow = value >= std::numeric_limits<std::int32_t>::min() &&
                 value <= std::numeric_limits<std::int32_t>::max();
    }
    if (narrow) return attribute<std::int32_t>(name, get);
    return attribute<std::int64_t>(name, get);
}

/// A further column of numbers in the smallest type that keeps every one.
PointAttribute columnAttribute(const std::string& name, const std::vector<double>& numbers) {
    bool whole = true;
    bool single = true;
    for (const double value : numbers) {
        std::int64_t ignored = 0;
        whole = whole && wholeNumber(value, ignored) && std::abs(value) < 0x1p53;
        single =
            single && (!std::isfinite(value) ||
                       (std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()) &&
                        static_cast<double>(static_cast<float>(value)) == value));
        if (!whole && !single) break;
    }
    if (whole)
        return wholeAttribute(name, numbers.size(), [&numbers](std::size_t i) {
            return static_cast<std::int64_t>(numbers[i]);
        });
    if (single) return attribute<float>(name, [&numbers](std::size_t i) { return numbers[i]; });
    return attribute<double>(name, [&numbers](std::size_t i) { return numbers[i]; });
}

/// Texts are stored as indices into a table in the metadata of the attributes.
PointAttribute textAttribute(const std::string& name, const std::vector<std::string>& texts,
                             openvdb::MetaMap& table) {
    points::StringMetaInserter inserter(table);
    auto indices = std::make_shared<std::vector<openvdb::Index>>();
    indices->reserve(texts.size());
    // The empty text is index 0 without an entry.
    for (const auto& t : texts) indices->push_back(t.empty() ? 0 : inserter.insert(t));
    return {name, points::StringAttributeArray::attributeType(),
            [indices](points::AttributeArray& array, const std::vector<std::size_t>& spheres) {
                auto& typed = points::StringAttributeArray::cast(array);
                typed.expand(false);
                for (openvdb::Index k = 0; k < spheres.size(); ++k)
                    typed.set(k, (*indices)[spheres[k]]);
                typed.compact();
            }};
}

std::vector<PointAttribute> attributesOf(const PackView& pack, openvdb::MetaMap& table) {
    std::vector<PointAttribute> list;
    UniqueNames unique{"p"};
    // Names that OpenVDB accepts.
    const auto named = [&unique](std::string_view name) {
        return unique(name.empty() ? "column" : identifierOf(name));
    };
    list.push_back(
        attribute<float>(named("pscale"), [&pack](std::size_t i) { return pack.radius(i); }));
    list.push_back(
        wholeAttribute(named("id"), pack.size(), [&pack](std::size_t i) { return pack.id(i); }));
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            using T = ValueOf<decltype(numbers)>;
            const auto get = [&pack, &numbers](std::size_t i) { return pack.value(numbers, i); };
            if constexpr (std::is_integral_v<T>)
                list.push_back(wholeAttribute(named(name), pack.size(), get));
            else if constexpr (std::is_same_v<T, float>)
                list.push_back(attribute<float>(named(name), get));
            else
                list.push_back(columnAttribute(named(name), numbers));
        },
        [&](std::string_view name, const auto& texts) {
            list.push_back(textAttribute(named(name), texts, table));
        });
    return list;
}

/// The point grid of a pack, its spheres sorted into leaves.
class PointGrid {
public:
    PointGrid(const PackView& pack, double voxel) : pack_(pack), voxel_(voxel) {}

    points::PointDataGrid::Ptr make() {
        sortIntoLeaves();
        describeAttributes();
        addLeaves();
        parallelFor(std::size_t{0}, runs_.size(), [this](std::size_t r) { fill(runs_[r]); });
        grid_->setName("points");
        // A pure scale by a power of two: index and offset give back the position without rounding.
        grid_->setTransform(openvdb::math::Transform::createLinearTransform(voxel_));
        return grid_;
    }

private:
    /// A sphere and the leaf that it belongs to.
    struct Entry {
        std::uint64_t leaf = 0;
        std::uint64_t sphere = 0;
    };
    /// The entries of one leaf.
    struct Run {
        std::size_t begin, end;
        Leaf* leaf;
    };

    std::array<double, 3> voxelOf(std::size_t sphere) const {
        const auto p = pack_.position(sphere);
        std::array<double, 3> v{};
        for (std::size_t d = 0; d < 3; ++d) v[d] = placed(p[d] / voxel_).voxel;
        return v;
    }
    openvdb::Coord coordOf(std::size_t sphere) const {
        const auto v = voxelOf(sphere);
        return {static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2])};
    }
    static double leafOf(double voxel) { return std::floor(voxel / kLeafDim); }

    void sortIntoLeaves() {
        if (pack_.size() == 0) return;
        std::array<double, 3> lowest{}, highest{};
        lowest.fill(std::numeric_limits<double>::infinity());
        highest.fill(-std::numeric_limits<double>::infinity());
        for (std::size_t i = 0; i < pack_.size(); ++i) {
            const auto v = voxelOf(i);
            for (std::size_t d = 0; d < 3; ++d) {
                lowest[d] = std::min(lowest[d], leafOf(v[d]));
                highest[d] = std::max(highest[d], leafOf(v[d]));
            }
        }
        entries_.resize(pack_.size());
        parallelFor(std::size_t{0}, pack_.size(), [&](std::size_t i) {
            const auto v = voxelOf(i);
            std::uint64_t key = 0;
            for (std::size_t d = 0; d < 3; ++d)
                key = key << 21 | static_cast<std::uint64_t>(leafOf(v[d]) - lowest[d]);
            entries_[i] = {key, i};
        });
        double leaves = 1;
        for (std::size_t d = 0; d < 3; ++d) leaves *= highest[d] - lowest[d] + 1;
        if (leaves <= static_cast<double>(pack_.size()))
            countIntoLeaves(static_cast<std::size_t>(leaves), highest, lowest);
        else
            tbb::parallel_sort(entries_.begin(), entries_.end(),
                               [](const Entry& a, const Entry& b) {
                                   return a.leaf != b.leaf ? a.leaf < b.leaf : a.sphere < b.sphere;
                               });
    }

    /// The same order where most leaves of the box around have spheres: by counting these.
    void countIntoLeaves(std::size_t leaves, const std::array<double, 3>& highest,
                         const std::array<double, 3>& lowest) {
        constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
        const auto ny = static_cast<std::uint64_t>(highest[1] - lowest[1]) + 1;
        const auto nz = static_cast<std::uint64_t>(highest[2] - lowest[2]) + 1;
        const auto leafAt = [&](const Entry& e) {
            return ((e.leaf >> 42) * ny + (e.leaf >> 21 & kMask)) * nz + (e.leaf & kMask);
        };
        std::vector<std::size_t> next(leaves + 1);
        for (const Entry& e : entries_) ++next[leafAt(e) + 1];
        std::partial_sum(next.begin(), next.end(), next.begin());
        std::vector<Entry> sorted(entries_.size());
        for (const Entry& e : entries_) sorted[next[leafAt(e)]++] = e;
        entries_.swap(sorted);
    }

    void describeAttributes() {
        descriptor_ =
            points::AttributeSet::Descriptor::create(Plain<openvdb::Vec3f>::attributeType());
        openvdb::MetaMap texts;
        attributes_ = attributesOf(pack_, texts);
        for (const auto& a : attributes_)
            descriptor_ = descriptor_->duplicateAppend(a.name, a.type);
        for (auto m = texts.beginMeta(); m != texts.endMeta(); ++m)
            descriptor_->getMetadata().insertMeta(m->first, *m->second);
    }

    void addLeaves() {
        const std::size_t n = entries_.size();
        for (std::size_t begin = 0; begin < n;) {
            std::size_t end = begin + 1;
            while (end < n && entries_[end].leaf == entries_[begin].leaf) ++end;
            if (end - begin > std::numeric_limits<std::int32_t>::max())
                throw ParameterError(
                    fmt::format("{} spheres fall into one leaf of the point grid; choose a smaller "
                                "voxel for it",
                                end - begin));
            runs_.push_back({begin, end, grid_->tree().touchLeaf(coordOf(entries_[begin].sphere))});
            begin = end;
        }
    }

    void fill(const Run& run) const {
        const std::size_t size = run.end - run.begin;
        // Count the spheres of each voxel; the sums are where its spheres end.
        std::vector<openvdb::Index> voxels(size);
        std::vector<Leaf::ValueType> ends(Leaf::SIZE, Leaf::ValueType(0));
        std::vector<std::size_t> starts(Leaf::SIZE + 1, 0);
        for (std::size_t k = 0; k < size; ++k) {
            voxels[k] = Leaf::coordToOffset(coordOf(entries_[run.begin + k].sphere));
            ++starts[voxels[k] + 1];
        }
        std::partial_sum(starts.begin(), starts.end(), starts.begin());
        for (openvdb::Index v = 0; v < Leaf::SIZE; ++v)
            ends[v] = Leaf::ValueType(static_cast<openvdb::Index32>(starts[v + 1]));
        std::vector<std::size_t> spheres(size);
        for (std::size_t k = 0; k < size; ++k)
            spheres[starts[voxels[k]]++] = entries_[run.begin + k].sphere;

        run.leaf->replaceAttributeSet(
            new points::AttributeSet(descriptor_, static_cast<openvdb::Index>(size)),
            /*allowMismatchingDescriptors=*/true);
        auto& positions = Plain<openvdb::Vec3f>::cast(run.leaf->attributeArray(0));
        positions.expand(false);
        for (openvdb::Index k = 0; k < size; ++k) {
            const auto p = pack_.position(spheres[k]);
            openvdb::Vec3f offset;
            for (int d = 0; d < 3; ++d)
                offset[d] = placed(p[static_cast<std::size_t>(d)] / voxel_).offset;
            positions.set(k, offset);
        }
        for (std::size_t a = 0; a < attributes_.size(); ++a)
            attributes_[a].fill(run.leaf->attributeArray(a + 1), spheres);
        run.leaf->setOffsets(ends);
    }

    const PackView& pack_;
    const double voxel_;
    std::vector<Entry> entries_;  ///< by leaf, then by sphere
    std::vector<PointAttribute> attributes_;
    points::AttributeSet::Descriptor::Ptr descriptor_;
    // Made by the library: a constructor here would compile all virtual functions of the tree.
    points::PointDataGrid::Ptr grid_ = openvdb::gridPtrCast<points::PointDataGrid>(
        openvdb::GridBase::createGrid(points::PointDataGrid::gridType()));
    std::vector<Run> runs_;
};

}  // namespace

void writeVdb(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    initializeOpenVdb();
    PointGrid points(pack, chooseVoxel(pack, options.pointVoxel));
    const auto grid = points.make();
    if (pack.cell().any())
        grid->insertMeta(kCellKey, openvdb::StringMetadata(cellText(pack.cell())));
    if (const auto names = partLines(pack.attributes()); !names.empty())
        grid->insertMeta(kPartNamesKey, openvdb::StringMetadata(names));
    writeGrids(options, {grid}, out);
}

void writePoints(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    PackWriteOptions alone = options;
    alone.levelSets.clear();
    writeVdb(pack, alone, out);
}

}  // namespace vdbpack
