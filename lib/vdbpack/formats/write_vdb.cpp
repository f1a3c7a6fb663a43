// OpenVDB files: spheres as a point grid, the bone as a level set beside them.
#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/field/vdb_check.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/AttributeArrayString.h>
#include <openvdb/points/PointDataGrid.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <set>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

namespace points = openvdb::points;
using Leaf = points::PointDataTree::LeafNodeType;
template <typename T>
using Plain = points::TypedAttributeArray<T>;  ///< the null codec: nothing is rounded further

/// Reads and writes streams of ours. The library's own classes open files themselves and do not
/// look whether the disk was full or the file cut short; a stream that throws does.
class Archive : public openvdb::io::Archive {
public:
    void writeTo(std::ostream& stream, const openvdb::GridCPtrVec& grids) {
        setCompression(hasBloscCompression()
                           ? openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK
                           : openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
        write(stream, grids, /*seekable=*/true);
    }

    /// The point grid named `name` (empty: the first one), or null; `found` lists all grids.
    /// The file has passed `checkVdbFile`.
    points::PointDataGrid::Ptr readPoints(std::istream& stream, const std::string& name,
                                          std::string& found) {
        readHeader(stream);
        auto tag = std::make_shared<openvdb::io::StreamMetadata>();
        openvdb::io::setStreamMetadataPtr(stream, tag, /*transfer=*/false);
        openvdb::io::setVersion(stream, libraryVersion(), fileVersion());
        openvdb::io::setDataCompression(stream, compression());
        openvdb::MetaMap meta;
        meta.readMeta(stream);
        const int count = readGridCount(stream);
        for (int i = 0; i < count; ++i) {
            openvdb::io::GridDescriptor descriptor;
            const auto grid = descriptor.read(stream);
            const std::string gridName =
                openvdb::io::GridDescriptor::stripSuffix(descriptor.gridName());
            if (found.size() < 500)
                found += fmt::format("{}'{}' ({})", i > 0 ? ", " : "", gridName.substr(0, 80),
                                     descriptor.gridType().substr(0, 80));
            const auto pointGrid = openvdb::gridPtrCast<points::PointDataGrid>(grid);
            const bool wanted =
                pointGrid && (name.empty() || name == gridName) && !descriptor.isInstance();
            if (wanted || !inputHasGridOffsets()) {
                readGrid(grid, descriptor, stream);
                if (wanted) return pointGrid;
            } else {
                descriptor.seekToEnd(stream);
            }
        }
        return nullptr;
    }
};

// ---- writing -----------------------------------------------------------------------------------

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
    Box<3> bounds;
    double filled = 0;
    double largest = 0;
    for (std::size_t i = 0; i < pack.size(); ++i) {
        const auto p = pack.position(i);
        bounds.add({{p[0], p[1], p[2]}});
        const double r = pack.radius(i);
        filled += pack.dim() == 2 ? Measure<2>::ball(r) : Measure<3>::ball(r);
        largest = std::max(largest, r);
    }
    double voxel = 0;
    if (wanted > 0) {
        voxel = std::exp2(std::round(std::log2(fromMillimeters(wanted, pack.unit()))));
    } else {
        // The part of the bounds that the bone takes is unknown; spheres fill 0.6 of it. A pack
        // with most of its spheres removed would get a leaf for each: hence the bounds' share.
        const Vec<3> size = bounds.grown(largest).size();
        const double box = pack.dim() == 2 ? size[0] * size[1] : size[0] * size[1] * size[2];
        voxel = pointVoxelSize(static_cast<double>(pack.size()), std::max(filled / 0.6, box / 8),
                               pack.dim());
        // Positions may lie on a lattice that is a little too fine for such voxels.
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
    while (extent / voxel > kLeafDim * (kLeavesPerAxis - 2) || reach / voxel > kMaxCoordinate)
        voxel *= 2;
    return voxel;
}

/// Names that OpenVDB accepts for attributes, each of them once.
class AttributeNames {
public:
    std::string unique(std::string_view name) {
        std::string clean;
        for (const char c : name) {
            const bool valid = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                               (c >= '0' && c <= '9') || c == '_';
            clean += valid ? c : '_';
        }
        if (clean.empty()) clean = "column";
        std::string candidate = clean;
        for (int n = 2; !used_.insert(candidate).second; ++n)
            candidate = fmt::format("{}_{}", clean, n);
        return candidate;
    }

private:
    std::set<std::string> used_;
};

/// An attribute of the point grid: its type, and how the array of a leaf is filled with the
/// spheres listed.
struct Attribute {
    std::string name;
    openvdb::NamePair type;
    std::function<void(points::AttributeArray&, const std::vector<std::size_t>&)> fill;
};

template <typename T, typename Get>
Attribute attribute(const std::string& name, const Get& get) {
    return {name, Plain<T>::attributeType(),
            [get](points::AttributeArray& array, const std::vector<std::size_t>& spheres) {
                auto& typed = Plain<T>::cast(array);
                typed.expand(false);
                for (openvdb::Index k = 0; k < spheres.size(); ++k)
                    typed.set(k, static_cast<T>(get(spheres[k])));
                // One value in the whole leaf is kept once.
                typed.compact();
            }};
}

/// Whole numbers as int32 where they fit, as viewers expect, else int64.
template <typename Get>
Attribute wholeAttribute(const std::string& name, std::size_t count, const Get& get) {
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
Attribute columnAttribute(const std::string& name, const std::vector<double>& numbers) {
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

/// Texts are numbers into a table that the metadata of the attributes holds.
Attribute textAttribute(const std::string& name, const std::vector<std::string>& texts,
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

std::vector<Attribute> attributesOf(const PackView& pack, openvdb::MetaMap& table) {
    AttributeNames names;
    std::vector<Attribute> list;
    names.unique("P");
    list.push_back(attribute<float>(names.unique("pscale"),
                                    [&pack](std::size_t i) { return pack.radius(i); }));
    list.push_back(wholeAttribute(names.unique("id"), pack.size(),
                                  [&pack](std::size_t i) { return pack.id(i); }));
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            using T = ValueOf<decltype(numbers)>;
            const auto get = [&pack, &numbers](std::size_t i) { return pack.value(numbers, i); };
            if constexpr (std::is_integral_v<T>)
                list.push_back(wholeAttribute(names.unique(name), pack.size(), get));
            else if constexpr (std::is_same_v<T, float>)
                list.push_back(attribute<float>(names.unique(name), get));
            else
                list.push_back(columnAttribute(names.unique(name), numbers));
        },
        [&](std::string_view name, const auto& texts) {
            list.push_back(textAttribute(names.unique(name), texts, table));
        });
    return list;
}

/// A sphere and the leaf that it belongs to.
struct Entry {
    std::uint64_t leaf = 0;
    std::uint64_t sphere = 0;
};

points::PointDataGrid::Ptr pointGrid(const PackView& pack, double voxel) {
    const std::size_t n = pack.size();
    const auto voxelOf = [&pack, voxel](std::size_t i) {
        const auto p = pack.position(i);
        std::array<double, 3> v{};
        for (std::size_t d = 0; d < 3; ++d) v[d] = placed(p[d] / voxel).voxel;
        return v;
    };
    const auto leafOf = [](double v) { return std::floor(v / kLeafDim); };

    std::array<double, 3> lowest{};
    lowest.fill(std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < n; ++i) {
        const auto v = voxelOf(i);
        for (std::size_t d = 0; d < 3; ++d) lowest[d] = std::min(lowest[d], leafOf(v[d]));
    }
    std::vector<Entry> entries(n);
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
        const auto v = voxelOf(i);
        std::uint64_t key = 0;
        for (std::size_t d = 0; d < 3; ++d)
            key = key << 21 | static_cast<std::uint64_t>(leafOf(v[d]) - lowest[d]);
        entries[i] = {key, i};
    });
    tbb::parallel_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return a.leaf != b.leaf ? a.leaf < b.leaf : a.sphere < b.sphere;
    });

    auto descriptor =
        points::AttributeSet::Descriptor::create(Plain<openvdb::Vec3f>::attributeType());
    openvdb::MetaMap texts;
    const auto attributes = attributesOf(pack, texts);
    for (const auto& a : attributes) descriptor = descriptor->duplicateAppend(a.name, a.type);
    for (auto m = texts.beginMeta(); m != texts.endMeta(); ++m)
        descriptor->getMetadata().insertMeta(m->first, *m->second);

    struct Run {
        std::size_t begin, end;
        Leaf* leaf;
    };
    auto tree = std::make_shared<points::PointDataTree>();
    std::vector<Run> runs;
    for (std::size_t begin = 0; begin < n;) {
        std::size_t end = begin + 1;
        while (end < n && entries[end].leaf == entries[begin].leaf) ++end;
        if (end - begin > std::numeric_limits<std::int32_t>::max())
            throw ParameterError(
                fmt::format("{} spheres fall into one leaf of the point grid; choose a smaller "
                            "voxel for it",
                            end - begin));
        const auto v = voxelOf(entries[begin].sphere);
        runs.push_back(
            {begin, end,
             tree->touchLeaf(openvdb::Coord(static_cast<int>(v[0]), static_cast<int>(v[1]),
                                            static_cast<int>(v[2])))});
        begin = end;
    }

    tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t r) {
        const Run& run = runs[r];
        const std::size_t size = run.end - run.begin;
        // Count the spheres of each voxel; the sums are where its spheres end.
        std::vector<openvdb::Index> voxels(size);
        std::vector<Leaf::ValueType> ends(Leaf::SIZE, Leaf::ValueType(0));
        std::vector<std::size_t> starts(Leaf::SIZE + 1, 0);
        for (std::size_t k = 0; k < size; ++k) {
            const auto v = voxelOf(entries[run.begin + k].sphere);
            voxels[k] = Leaf::coordToOffset(openvdb::Coord(
                static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2])));
            ++starts[voxels[k] + 1];
        }
        std::partial_sum(starts.begin(), starts.end(), starts.begin());
        for (openvdb::Index v = 0; v < Leaf::SIZE; ++v)
            ends[v] = Leaf::ValueType(static_cast<openvdb::Index32>(starts[v + 1]));
        std::vector<std::size_t> spheres(size);
        for (std::size_t k = 0; k < size; ++k)
            spheres[starts[voxels[k]]++] = entries[run.begin + k].sphere;

        run.leaf->replaceAttributeSet(
            new points::AttributeSet(descriptor, static_cast<openvdb::Index>(size)),
            /*allowMismatchingDescriptors=*/true);
        auto& positions = Plain<openvdb::Vec3f>::cast(run.leaf->attributeArray(0));
        positions.expand(false);
        for (openvdb::Index k = 0; k < size; ++k) {
            const auto p = pack.position(spheres[k]);
            openvdb::Vec3f offset;
            for (int d = 0; d < 3; ++d)
                offset[d] = placed(p[static_cast<std::size_t>(d)] / voxel).offset;
            positions.set(k, offset);
        }
        for (std::size_t a = 0; a < attributes.size(); ++a)
            attributes[a].fill(run.leaf->attributeArray(a + 1), spheres);
        run.leaf->setOffsets(ends);
    });

    auto grid = points::PointDataGrid::create(tree);
    grid->setName("points");
    // A pure scale by a power of two: index and offset give back the position without rounding.
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    return grid;
}

/// The level set in the unit that is written; shares the tree where that is mm.
openvdb::FloatGrid::Ptr levelSetIn(const VdbGrid& surface, Unit unit) {
    openvdb::FloatGrid::Ptr grid;
    if (unit == Unit::millimeter) {
        grid = surface.grid->copy();
    } else {
        grid = surface.grid->deepCopy();
        const double scale = fromMillimeters(1.0, unit);
        grid->setTransform(surface.grid->transform().copy());
        grid->transform().postScale(scale);
        const auto scaled = [scale](float value) {
            return static_cast<float>(scale * static_cast<double>(value));
        };
        auto& tree = grid->tree();
        openvdb::tree::LeafManager<openvdb::FloatTree> leaves(tree);
        leaves.foreach ([&scaled](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
            for (auto v = leaf.beginValueAll(); v; ++v) v.setValue(scaled(*v));
        });
        auto tile = tree.beginValueAll();
        tile.setMaxDepth(openvdb::FloatTree::ValueAllIter::LEAF_DEPTH - 1);
        for (; tile; ++tile) tile.setValue(scaled(*tile));
        tree.root().setBackground(scaled(tree.background()), /*updateChildNodes=*/false);
    }
    grid->setName(surface.grid->getName());
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
}

// ---- reading -----------------------------------------------------------------------------------

/// Values of one attribute in one leaf, put into a column of the pack.
using Put = std::function<bool(PackBuilder&, std::size_t column, openvdb::Index point)>;

template <typename T>
Put putNumber(const points::AttributeArray& array) {
    auto handle = std::make_shared<points::AttributeHandle<T>>(array);
    return [handle](PackBuilder& builder, std::size_t column, openvdb::Index point) {
        const T value = handle->get(point);
        if constexpr (std::is_floating_point_v<T>)
            return builder.set(column, static_cast<double>(value));
        else
            return builder.set(column, static_cast<std::int64_t>(value));
    };
}

template <typename V>
Put putComponent(const points::AttributeArray& array, int component) {
    auto handle = std::make_shared<points::AttributeHandle<V>>(array);
    return [handle, component](PackBuilder& builder, std::size_t column, openvdb::Index point) {
        return builder.set(column, static_cast<double>(handle->get(point)[component]));
    };
}

/// What a column of the pack is read from.
struct Source {
    std::size_t attribute = 0;
    int component = 0;
};

bool isText(const std::string& type, const std::string& codec) {
    return codec == points::StringCodec<false>::name() && type != "group";
}

/// @return nothing for a type that is not a number.
Put putOf(const points::AttributeArray& array, const openvdb::MetaMap& meta, int component) {
    const std::string type = array.valueType();
    if (isText(type, array.codecType())) {
        auto handle = std::make_shared<points::StringAttributeHandle>(array, meta);
        return [handle](PackBuilder& builder, std::size_t column, openvdb::Index point) {
            builder.setText(column, handle->get(point));
            return true;
        };
    }
    if (type == openvdb::typeNameAsString<float>()) return putNumber<float>(array);
    if (type == openvdb::typeNameAsString<double>()) return putNumber<double>(array);
    if (type == openvdb::typeNameAsString<std::int8_t>()) return putNumber<std::int8_t>(array);
    if (type == openvdb::typeNameAsString<std::int16_t>()) return putNumber<std::int16_t>(array);
    if (type == openvdb::typeNameAsString<std::int32_t>()) return putNumber<std::int32_t>(array);
    if (type == openvdb::typeNameAsString<std::int64_t>()) return putNumber<std::int64_t>(array);
    if (type == openvdb::typeNameAsString<bool>()) return putNumber<bool>(array);
    if (type == openvdb::typeNameAsString<openvdb::Vec3f>())
        return putComponent<openvdb::Vec3f>(array, component);
    if (type == openvdb::typeNameAsString<openvdb::Vec3d>())
        return putComponent<openvdb::Vec3d>(array, component);
    return {};
}

int componentsOf(const std::string& type) {
    return type == openvdb::typeNameAsString<openvdb::Vec3f>() ||
                   type == openvdb::typeNameAsString<openvdb::Vec3d>()
               ? 3
               : 1;
}

template <typename T>
void permute(std::vector<T>& values, const std::vector<std::size_t>& order) {
    if (values.empty()) return;
    std::vector<T> sorted;
    sorted.reserve(values.size());
    for (const std::size_t from : order) sorted.push_back(std::move(values[from]));
    values = std::move(sorted);
}

/// Spheres by id: a point grid keeps them by place.
void sortById(Pack<3>& pack) {
    if (std::is_sorted(pack.id.begin(), pack.id.end())) return;
    std::vector<std::size_t> order(pack.id.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    tbb::parallel_sort(order.begin(), order.end(), [&pack](std::size_t a, std::size_t b) {
        return pack.id[a] != pack.id[b] ? pack.id[a] < pack.id[b] : a < b;
    });
    permute(pack.spheres, order);
    forEachAttribute(pack, [&order](std::string_view, auto& values) { permute(values, order); });
}

/// The pack that a point grid holds; lengths in its unit.
Pack<3> packOf(const points::PointDataGrid& grid, const std::string& path, Unit unit) {
    const auto firstLeaf = grid.tree().cbeginLeaf();
    if (!firstLeaf) return {};
    const auto& descriptor = firstLeaf->attributeSet().descriptor();
    std::vector<std::pair<std::size_t, std::string>> byPosition;
    for (const auto& entry : descriptor.map()) byPosition.emplace_back(entry.second, entry.first);
    std::sort(byPosition.begin(), byPosition.end());

    std::vector<std::string> names = {"x", "y", "z"};
    std::vector<Source> sources;
    std::vector<std::size_t> textColumns;
    std::size_t positionAttribute = points::AttributeSet::INVALID_POS;
    for (const auto& [at, name] : byPosition) {
        const auto& array = firstLeaf->constAttributeArray(at);
        const std::string type = array.valueType();
        if (name == "P" && componentsOf(type) == 3) {
            positionAttribute = at;
            continue;
        }
        // Groups and types that are no numbers say nothing that a pack could keep.
        if (!putOf(array, descriptor.getMetadata(), 0)) continue;
        for (int c = 0; c < componentsOf(type); ++c) {
            if (isText(type, array.codecType())) textColumns.push_back(names.size());
            names.push_back(componentsOf(type) == 1 ? name : fmt::format("{}_{}", name, c));
            sources.push_back({at, c});
        }
    }
    if (positionAttribute == points::AttributeSet::INVALID_POS)
        throw InputError(fmt::format("{}: point grid '{}' has no positions 'P'; write it with them",
                                     path, grid.getName()));
    PackBuilder builder(path, names, unit);
    for (const std::size_t column : textColumns) {
        if (!builder.isFurther(column))
            throw InputError(fmt::format("{}: attribute '{}' holds texts; numbers are needed", path,
                                         names[column]));
        builder.makeText(column);
    }

    std::uint64_t count = 0;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (leaf->attributeSet().descriptor() != descriptor)
            throw InputError(path + ": leaves of its point grid have different attributes");
        // Whether every array has as many values as the voxels claim.
        leaf->validateOffsets();
        count += leaf->attributeSet().get(0)->size();
    }
    builder.reserve(static_cast<std::size_t>(count));

    const auto& transform = grid.transform();
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        const auto& positionArray = leaf->constAttributeArray(positionAttribute);
        std::unique_ptr<points::AttributeHandle<openvdb::Vec3f>> single;
        std::unique_ptr<points::AttributeHandle<openvdb::Vec3d>> twice;
        if (positionArray.valueType() == openvdb::typeNameAsString<openvdb::Vec3f>())
            single = std::make_unique<points::AttributeHandle<openvdb::Vec3f>>(positionArray);
        else
            twice = std::make_unique<points::AttributeHandle<openvdb::Vec3d>>(positionArray);
        std::vector<Put> puts;
        puts.reserve(sources.size());
        for (const auto& s : sources)
            puts.push_back(putOf(leaf->constAttributeArray(s.attribute), descriptor.getMetadata(),
                                 s.component));

        openvdb::Index begin = 0;
        for (openvdb::Index v = 0; v < Leaf::SIZE; ++v) {
            const openvdb::Index end = leaf->getValue(v);
            const openvdb::Vec3d voxel = leaf->offsetToGlobalCoord(v).asVec3d();
            for (openvdb::Index k = begin; k < end; ++k) {
                const openvdb::Vec3d offset =
                    single ? openvdb::Vec3d(single->get(k)) : twice->get(k);
                const openvdb::Vec3d world = transform.indexToWorld(voxel + offset);
                const auto where = [&] {
                    return fmt::format("point {} of leaf ({}, {}, {})", k, leaf->origin()[0],
                                       leaf->origin()[1], leaf->origin()[2]);
                };
                builder.addRow();
                for (int d = 0; d < 3; ++d) builder.set(static_cast<std::size_t>(d), world[d]);
                for (std::size_t s = 0; s < puts.size(); ++s)
                    if (!puts[s](builder, s + 3, k))
                        builder.failCell(where(), s + 3, "out of range");
                if (!builder.problem().empty()) builder.failRow(where());
            }
            begin = end;
        }
    }
    Pack<3> pack = builder.finish();
    sortById(pack);
    dropDefaultIds(pack);
    return pack;
}

Unit unitOf(const openvdb::GridBase& grid, const std::string& path, Unit fallback) {
    const auto meta = grid.getMetadata<openvdb::StringMetadata>(kUnitKey);
    if (!meta) return fallback;
    try {
        return parseUnit(meta->value());
    } catch (const ParameterError& e) {
        throw InputError(path + ": " + kUnitKey + ": " + e.what());
    }
}

}  // namespace

namespace {

/// The level sets of the options, and further grids, with what is recorded in each.
void writeGrids(const PackWriteOptions& options, const std::vector<openvdb::GridBase::Ptr>& others,
                OutputFile& out) {
    openvdb::GridCPtrVec grids;
    const auto add = [&](const openvdb::GridBase::Ptr& grid) {
        grid->insertMeta(kUnitKey, openvdb::StringMetadata(unitName(options.unit)));
        if (!options.generator.empty())
            grid->insertMeta(kGeneratorKey, openvdb::StringMetadata(options.generator));
        grids.push_back(grid);
    };
    for (const auto& set : options.levelSets)
        if (set && set->grid) add(levelSetIn(*set, options.unit));
    for (const auto& grid : others) add(grid);

    // Whether it was the disk: a stream of the library would not tell.
    std::ofstream stream;
    errno = 0;
    try {
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(out.temporaryPath(), std::ios::binary | std::ios::trunc);
        Archive().writeTo(stream, grids);
        stream.close();
    } catch (const std::exception& e) {
        const int cause = errno;
        // Destroying a stream that throws on failure must not throw once more.
        stream.exceptions(std::ios::goodbit);
        if (isShortage(e)) throw;
        throw IoError(fmt::format("{}: writing failed: {}; the former file, if any, is untouched",
                                  out.path(), cause != 0 ? std::strerror(cause) : e.what()));
    }
}

}  // namespace

void writeVdb(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    openvdb::initialize();
    writeGrids(options, {pointGrid(pack, chooseVoxel(pack, options.pointVoxel))}, out);
}

void writeLevelSets(const std::string& file, const PackWriteOptions& options) {
    OutputFile out(file);
    openvdb::initialize();
    writeGrids(options, {}, out);
    out.commit();
}

void writeFog(const VdbGrid& levelSet, const std::string& file, const PackWriteOptions& options) {
    OutputFile out(file);
    openvdb::initialize();
    // Shares of the band's depth: no unit, but voxels have one.
    const auto grid = levelSet.grid->deepCopy();
    grid->setTransform(levelSet.grid->transform().copy());
    grid->transform().postScale(fromMillimeters(1.0, options.unit));
    openvdb::tools::sdfToFogVolume(*grid);
    grid->setName("density");
    PackWriteOptions alone = options;
    alone.levelSets.clear();
    writeGrids(alone, {grid}, out);
    out.commit();
}

Pack<3> readVdb(const std::string& path, const PackReadOptions& options) {
    checkVdbFile(path);
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw IoError(path + ": cannot be read: " + std::strerror(errno));
    std::string found;
    try {
        stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
        const auto grid = Archive().readPoints(stream, options.gridName, found);
        if (grid) return packOf(*grid, path, unitOf(*grid, path, options.unit));
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        stream.exceptions(std::ios::goodbit);
        if (isShortage(e)) throw;
        stream.clear();
        const auto at = static_cast<std::int64_t>(stream.tellg());
        throw InputError(fmt::format(
            "{}: cannot be read as OpenVDB near byte {}: {}; the file is damaged or cut "
            "short",
            path, at, e.what()));
    }
    throw InputError(fmt::format("{}: holds no point grid{}, but {}; name another grid or file",
                                 path,
                                 options.gridName.empty() ? "" : " '" + options.gridName + "'",
                                 found.empty() ? "nothing" : found));
}

}  // namespace vdbpack
