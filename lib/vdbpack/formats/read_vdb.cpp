// OpenVDB files: a point grid as spheres.
#include "vdbpack/field/read_vdb.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/vdb_archive.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <openvdb/Grid.h>
#include <openvdb/points/AttributeArrayString.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

namespace points = openvdb::points;
using Leaf = points::PointDataTree::LeafNodeType;

/// Puts the value of one attribute at a point of a leaf into a column of the pack.
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

/// Of an array of one of some types; empty for one of another.
template <typename... T>
Put putAnyOf(const points::AttributeArray& array) {
    const std::string type = array.valueType();
    Put put;
    static_cast<void>(
        ((type == openvdb::typeNameAsString<T>() && (put = putNumber<T>(array), true)) || ...));
    return put;
}

template <typename V>
Put putComponent(const points::AttributeArray& array, int component) {
    auto handle = std::make_shared<points::AttributeHandle<V>>(array);
    return [handle, component](PackBuilder& builder, std::size_t column, openvdb::Index point) {
        return builder.set(column, static_cast<double>(handle->get(point)[component]));
    };
}

/// The attribute, and its component, that a column of the pack is read from.
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
    if (Put put =
            putAnyOf<float, double, std::int8_t, std::int16_t, std::int32_t, std::int64_t, bool>(
                array))
        return put;
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

/// The spheres by rising id, those of one id as they come.
std::vector<std::size_t> orderOf(const std::vector<std::int64_t>& ids) {
    const std::size_t n = ids.size();
    std::vector<std::size_t> order(n, n);
    const std::int64_t lowest = *std::min_element(ids.begin(), ids.end());
    // Most packs count their spheres: each id is its place.
    const bool counts = std::all_of(ids.begin(), ids.end(), [&](const std::int64_t& id) {
        const std::uint64_t place =
            static_cast<std::uint64_t>(id) - static_cast<std::uint64_t>(lowest);
        if (place >= n || order[place] != n) return false;
        order[place] = static_cast<std::size_t>(&id - ids.data());
        return true;
    });
    if (counts) return order;
    std::iota(order.begin(), order.end(), std::size_t{0});
    tbb::parallel_sort(order.begin(), order.end(), [&ids](std::size_t a, std::size_t b) {
        return ids[a] != ids[b] ? ids[a] < ids[b] : a < b;
    });
    return order;
}

/// Sorts spheres by id: a point grid stores them by position.
void sortById(Pack<3>& pack) {
    if (std::is_sorted(pack.id.begin(), pack.id.end())) return;
    const std::vector<std::size_t> order = orderOf(pack.id);
    permute(pack.spheres, order);
    forEachAttribute(pack, [&order](std::string_view, auto& values) { permute(values, order); });
}

/// Reads the spheres of a point grid.
class PointReader {
public:
    /// @param options  with the unit of lengths in the grid.
    PointReader(const points::PointDataGrid& grid, std::string path, PackReadOptions options)
        : grid_(grid), path_(std::move(path)), options_(std::move(options)) {}

    Pack<3> read() {
        const auto firstLeaf = grid_.tree().cbeginLeaf();
        if (!firstLeaf) return {};
        chooseColumns(*firstLeaf);
        PackBuilder builder(path_, names_, options_);
        for (const std::size_t column : textColumns_) builder.makeText(column);
        builder.reserve(static_cast<std::size_t>(count(firstLeaf->attributeSet().descriptor())));
        for (auto leaf = grid_.tree().cbeginLeaf(); leaf; ++leaf) append(*leaf, builder);
        Pack<3> pack = builder.finish();
        sortById(pack);
        dropDefaultIds(pack);
        return pack;
    }

private:
    void chooseColumns(const Leaf& leaf) {
        const auto& descriptor = leaf.attributeSet().descriptor();
        std::vector<std::pair<std::size_t, std::string>> byIndex;
        for (const auto& entry : descriptor.map()) byIndex.emplace_back(entry.second, entry.first);
        std::sort(byIndex.begin(), byIndex.end());
        for (const auto& [at, name] : byIndex) {
            const auto& array = leaf.constAttributeArray(at);
            const std::string type = array.valueType();
            if (name == "P" && componentsOf(type) == 3) {
                positions_ = at;
                continue;
            }
            // A pack has no columns for groups and for types that are not numbers.
            if (!putOf(array, descriptor.getMetadata(), 0)) continue;
            addNames(names_, name, static_cast<std::uint64_t>(componentsOf(type)));
            for (int c = 0; c < componentsOf(type); ++c) sources_.push_back({at, c});
            if (isText(type, array.codecType())) textColumns_.push_back(names_.size() - 1);
        }
        if (positions_ == points::AttributeSet::INVALID_POS)
            throw InputError(
                fmt::format("{}: point grid '{}' has no positions 'P'; write it with them", path_,
                            grid_.getName()));
    }

    /// The number of points, once their attributes are known to be sound.
    std::uint64_t count(const points::AttributeSet::Descriptor& descriptor) const {
        std::uint64_t sum = 0;
        for (auto leaf = grid_.tree().cbeginLeaf(); leaf; ++leaf) {
            if (leaf->attributeSet().descriptor() != descriptor)
                throw InputError(
                    fmt::format("{}: leaves of point grid '{}' have different attributes; write it "
                                "with the same in all",
                                path_, grid_.getName()));
            // Throws unless every array has as many values as the voxels announce.
            leaf->validateOffsets();
            sum += leaf->attributeSet().get(0)->size();
        }
        return sum;
    }

    /// Returns the offset of a point from the center of its voxel, in voxels.
    static std::function<openvdb::Vec3d(openvdb::Index)> offsetsOf(
        const points::AttributeArray& positions) {
        if (positions.valueType() == openvdb::typeNameAsString<openvdb::Vec3f>())
            return [handle = std::make_shared<points::AttributeHandle<openvdb::Vec3f>>(positions)](
                       openvdb::Index point) { return openvdb::Vec3d(handle->get(point)); };
        return [handle = std::make_shared<points::AttributeHandle<openvdb::Vec3d>>(positions)](
                   openvdb::Index point) { return handle->get(point); };
    }

    void append(const Leaf& leaf, PackBuilder& builder) const {
        const auto offsetOf = offsetsOf(leaf.constAttributeArray(positions_));
        const auto& meta = leaf.attributeSet().descriptor().getMetadata();
        std::vector<Put> puts;
        puts.reserve(sources_.size());
        for (const auto& s : sources_)
            puts.push_back(putOf(leaf.constAttributeArray(s.attribute), meta, s.component));

        openvdb::Index begin = 0;
        for (openvdb::Index v = 0; v < Leaf::SIZE; ++v) {
            const openvdb::Index end = leaf.getValue(v);
            const openvdb::Vec3d voxel = leaf.offsetToGlobalCoord(v).asVec3d();
            for (openvdb::Index k = begin; k < end; ++k) {
                const auto where = [&leaf, k] {
                    return fmt::format("point {} of leaf ({}, {}, {})", k, leaf.origin()[0],
                                       leaf.origin()[1], leaf.origin()[2]);
                };
                const openvdb::Vec3d world = grid_.transform().indexToWorld(voxel + offsetOf(k));
                builder.addRow();
                for (int d = 0; d < 3; ++d) builder.set(static_cast<std::size_t>(d), world[d]);
                for (std::size_t s = 0; s < puts.size(); ++s)
                    if (!puts[s](builder, s + 3, k))
                        builder.failCell(where(), s + 3, "out of range");
                builder.checkRow(where);
            }
            begin = end;
        }
    }

    const points::PointDataGrid& grid_;
    std::string path_;
    PackReadOptions options_;
    std::size_t positions_ = points::AttributeSet::INVALID_POS;  ///< index of the attribute
    std::vector<std::string> names_ = {"x", "y", "z"};
    std::vector<Source> sources_;  ///< of the columns after x, y and z
    std::vector<std::size_t> textColumns_;
};

/// A text in the metadata; empty if there is none.
std::string noted(const openvdb::GridBase& grid, const char* key) {
    const auto meta = grid.getMetadata<openvdb::StringMetadata>(key);
    return meta ? meta->value() : std::string();
}

}  // namespace

Pack<3> readVdb(const std::string& path, const PackReadOptions& options) {
    std::optional<Pack<3>> pack;
    readVdb(path, [&] {
        VdbArchive file(path);
        const auto grid = openvdb::gridPtrCast<points::PointDataGrid>(
            file.find([&](const openvdb::GridBase& head) {
                return head.isType<points::PointDataGrid>() &&
                       (options.gridName.empty() || file.isNamed(head, options.gridName));
            }));
        const std::string found = file.list();
        if (!grid)
            throw InputError(fmt::format(
                "{}: holds no point grid{}, but {}; name another grid or file{}", path,
                options.gridName.empty() ? "" : " '" + options.gridName + "'",
                found.empty() ? "nothing" : found,
                findFogVolume(path, options.gridName, true)
                    ? ". A fog volume is a domain of pack and voids, with `threshold` at its wall"
                    : ""));
        const std::string unit = noted(*grid, kUnitKey), cell = noted(*grid, kCellKey);
        PackReadOptions stated = options;
        if (!unit.empty()) stated.unit = unitNamed(unit, path);
        pack = PointReader(*grid, path, stated).read();
        pack->origin = originIn(noted(*grid, kGeneratorKey));
        if (!cell.empty()) pack->cell = cellIn(cell, stated.unit, path);
        if (const std::string names = noted(*grid, kPartNamesKey); !names.empty())
            setPartNames(*pack, splitAt(names, '\n'));
    });
    return std::move(*pack);
}

}  // namespace vdbpack
