#include "vdbpack/image/image_surface.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>

namespace vdbpack {

namespace {

constexpr std::size_t kMostLabels = 1000;
/// More labels than these, of which neighbors are seldom equal, are grey values.
constexpr std::size_t kFewLabels = 20;
/// Voxels around a selection that are looked at with it: its neighbors shape its surface.
constexpr std::size_t kMargin = 3;

/// What a thread found of a layer; stretches are voxels along a row that have the same value.
struct Tally {
    std::map<std::int64_t, LabelCount> counts;
    std::size_t stretches = 0;
    bool whole = true;
};

/// Part of a grid, by indices.
struct Region {
    std::array<std::size_t, 3> first{}, size{};
};

Region around(const Box<3>& voxels, const ImageGrid& grid) {
    Region region;
    for (int d = 0; d < 3; ++d) {
        const auto k = static_cast<std::size_t>(d);
        const auto lo = static_cast<std::size_t>(voxels.lo[d]);
        const auto hi = static_cast<std::size_t>(voxels.hi[d]);
        region.first[k] = lo > kMargin ? lo - kMargin : 0;
        region.size[k] = std::min(grid.size[k], hi + kMargin + 1) - region.first[k];
    }
    return region;
}

ImageGrid gridOf(const Region& region, ImageGrid grid) {
    Vec<3> first;
    for (std::size_t d = 0; d < 3; ++d) first.c[d] = static_cast<double>(region.first[d]);
    grid.origin = grid.at(first);
    grid.size = region.size;
    return grid;
}

/// Calls `work(from, to, count)` for each row of a region: index of its first voxel in the image,
/// and in the region.
template <class Work>
void forEachRow(const ImageGrid& grid, const Region& region, const Work& work) {
    parallelFor(IndexRange(0, region.size[1] * region.size[2], 64), [&](const IndexRange& rows) {
        for (std::size_t row = rows.begin(); row < rows.end(); ++row) {
            const std::size_t y = region.first[1] + row % region.size[1];
            const std::size_t z = region.first[2] + row / region.size[1];
            work((z * grid.size[1] + y) * grid.size[0] + region.first[0], row * region.size[0]);
        }
    });
}

/// Counts the labels of a row of voxels.
template <class T>
void addRow(const Image& image, const T* numbers, std::size_t layer, std::size_t row,
            Tally& tally) {
    const auto& size = image.grid.size;
    const T* const at = numbers + row * size[0] * image.layers + layer;
    const auto valueAt = [&](std::size_t x) { return image.value(at[x * image.layers]); };
    for (std::size_t x = 0; x < size[0];) {
        const double value = valueAt(x);
        std::size_t end = x + 1;
        while (end < size[0] && valueAt(end) == value) ++end;
        if (!(std::fabs(value) < 1e9) || value != std::floor(value)) {
            tally.whole = false;
            return;
        }
        if (value != 0) {
            LabelCount& label = tally.counts[static_cast<std::int64_t>(value)];
            label.voxels += end - x;
            ++tally.stretches;
            const auto y = static_cast<double>(row % size[1]);
            const auto z = static_cast<double>(row / size[1]);
            label.voxelBox.add({{static_cast<double>(x), y, z}});
            label.voxelBox.add({{static_cast<double>(end - 1), y, z}});
            if (tally.counts.size() > kMostLabels) tally.whole = false;
        }
        x = end;
    }
}

/// A value in a layer.
std::string textOf(const LabelCount& label) {
    return fmt::format("{}@{}", label.value, label.layer);
}

std::string listOf(const std::vector<LabelCount>& labels) {
    constexpr std::size_t kMost = 40;
    std::string text;
    for (std::size_t i = 0; i < std::min(labels.size(), kMost); ++i) {
        text += (i > 0 ? ", " : "") + std::to_string(labels[i].value);
        if (!labels[i].name.empty()) text += " (" + labels[i].name + ")";
    }
    return labels.size() > kMost ? text + ", ..." : text;
}

/// The label with a value or a name.
const LabelCount& labelOf(const std::string& text, const std::vector<LabelCount>& labels,
                          const std::string& path) {
    std::vector<const LabelCount*> found;
    for (const LabelCount& label : labels)
        if (label.name == text) found.push_back(&label);
    for (const LabelCount& label : labels)
        if (found.size() == 1 && &label != found.front() && std::to_string(label.value) == text)
            throw ParameterError(fmt::format(
                "`label` {}: is the value of one label of {} and the name of another; write {} for "
                "the value, {} for the name",
                text, path, textOf(label), textOf(*found.front())));
    if (found.empty())
        for (const LabelCount& label : labels)
            if (std::to_string(label.value) == text || textOf(label) == text)
                found.push_back(&label);
    if (found.size() == 1) return *found.front();
    if (text.empty())
        throw ParameterError(
            "`label`: a label is missing between the separators; write A,B for parts, or A+B for "
            "one part");
    if (found.empty())
        throw ParameterError(fmt::format(
            "`label` {}: {} has no such label; it has {}. A name with a comma or a plus "
            "is given by its value",
            text, path, listOf(labels)));
    throw ParameterError(
        fmt::format("`label` {}: {} has {} of them; {} is the first. The labels are {}", text, path,
                    found.size(), textOf(*found.front()), listOf(labels)));
}

}  // namespace

std::optional<std::vector<LabelCount>> labelsOf(const Image& image) {
    const auto& size = image.grid.size;
    PerThread<std::vector<Tally>> tallies([&] { return std::vector<Tally>(image.layers); });
    image.visit([&](const auto* numbers) {
        parallelFor(IndexRange(0, size[1] * size[2], 64), [&](const IndexRange& rows) {
            auto& mine = tallies.local();
            for (std::size_t layer = 0; layer < image.layers; ++layer)
                for (std::size_t row = rows.begin(); row < rows.end() && mine[layer].whole; ++row)
                    addRow(image, numbers, layer, row, mine[layer]);
        });
    });
    std::vector<LabelCount> labels;
    for (std::size_t layer = 0; layer < image.layers; ++layer) {
        std::map<std::int64_t, LabelCount> all;
        std::size_t stretches = 0, voxels = 0;
        for (const auto& mine : tallies) {
            if (!mine[layer].whole) return std::nullopt;
            stretches += mine[layer].stretches;
            for (const auto& [value, count] : mine[layer].counts) {
                voxels += count.voxels;
                LabelCount& label = all[value];
                label.value = value;
                label.layer = layer;
                label.voxels += count.voxels;
                label.voxelBox.add(count.voxelBox.lo);
                label.voxelBox.add(count.voxelBox.hi);
            }
        }
        if (all.size() > kMostLabels) return std::nullopt;
        if (all.size() > kFewLabels && voxels < 2 * stretches) return std::nullopt;
        for (const auto& [value, label] : all) labels.push_back(label);
    }
    for (LabelCount& label : labels)
        for (const LabelName& known : image.names)
            if (known.value == label.value && known.layer == label.layer) label.name = known.name;
    return labels;
}

std::pair<double, double> valueRange(const Image& image) {
    using Range = std::pair<double, double>;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Range numbers = image.visit([&](const auto* at) {
        return tbb::parallel_reduce(
            IndexRange(0, image.values(), 65536), Range{kInfinity, -kInfinity},
            [&](const IndexRange& block, Range range) {
                for (std::size_t i = block.begin(); i < block.end(); ++i) {
                    const auto value = static_cast<double>(at[i]);
                    range.first = std::min(range.first, value);
                    range.second = std::max(range.second, value);
                }
                return range;
            },
            [](const Range& a, const Range& b) {
                return Range{std::min(a.first, b.first), std::max(a.second, b.second)};
            });
    });
    const double a = image.slope * numbers.first + image.intercept;
    const double b = image.slope * numbers.second + image.intercept;
    return std::minmax(a, b);
}

std::vector<LabelPart> parseLabels(const std::string& text, const std::vector<LabelCount>& labels,
                                   const std::string& path) {
    std::vector<LabelPart> parts;
    if (labels.empty()) throw InputError(path + ": has no label, all voxels are 0");
    if (text == "all") {
        const auto nameOf = [](const LabelCount& label) {
            return label.name.empty() ? std::to_string(label.value) : label.name;
        };
        for (const LabelCount& label : labels) {
            const bool shared =
                std::count_if(labels.begin(), labels.end(), [&](const LabelCount& other) {
                    return nameOf(other) == nameOf(label);
                }) > 1;
            parts.push_back(
                {shared ? fmt::format("{} ({})", nameOf(label), textOf(label)) : nameOf(label),
                 {label}});
        }
        return parts;
    }
    std::vector<const LabelCount*> used;
    for (const std::string& one : splitAt(text, ',')) {
        LabelPart part;
        part.name = one;
        for (const std::string& name : splitAt(one, '+')) {
            const LabelCount& label = labelOf(name, labels, path);
            if (std::find(used.begin(), used.end(), &label) != used.end())
                throw ParameterError("`label` " + text + ": has " + name + " twice");
            used.push_back(&label);
            part.labels.push_back(label);
        }
        parts.push_back(part);
    }
    return parts;
}

std::vector<TriangleMesh> labelSurfaces(const Image& image, const std::vector<LabelCount>& labels,
                                        const std::vector<LabelPart>& parts) {
    const std::size_t layer = parts.front().labels.front().layer;
    // The numbers of labels in the net: those of parts by part, then all others.
    std::map<std::int64_t, std::uint16_t> numbers;
    Box<3> box;
    std::uint16_t next = 1;
    for (const LabelPart& part : parts) {
        for (const LabelCount& label : part.labels) {
            numbers[label.value] = next;
            box.add(label.voxelBox.lo);
            box.add(label.voxelBox.hi);
        }
        ++next;
    }
    for (const LabelCount& label : labels)
        if (label.layer == layer && numbers.emplace(label.value, next).second) ++next;

    const Region region = around(box, image.grid);
    LabelVoxels voxels;
    voxels.size = region.size;
    voxels.labels.resize(region.size[0] * region.size[1] * region.size[2]);
    image.visit([&](const auto* values) {
        forEachRow(image.grid, region, [&](std::size_t from, std::size_t to) {
            std::int64_t last = 0;
            std::uint16_t number = 0;
            for (std::size_t x = 0; x < region.size[0]; ++x) {
                const auto value = static_cast<std::int64_t>(
                    image.value(values[(from + x) * image.layers + layer]));
                if (value != last) {
                    last = value;
                    number = value == 0 ? std::uint16_t{0} : numbers.at(value);
                }
                voxels.labels[to + x] = number;
            }
        });
    });
    SurfaceNet net = surfaceNet(voxels);
    smooth(net, voxels.size);
    const ImageGrid grid = gridOf(region, image.grid);
    std::vector<TriangleMesh> meshes;
    for (std::size_t p = 0; p < parts.size(); ++p)
        meshes.push_back(surfaceOf(net, grid, [p](std::uint16_t label) { return label == p + 1; }));
    return meshes;
}

TriangleMesh thresholdSurface(const Image& image, double threshold, const std::string& path,
                              const Callbacks& callbacks) {
    LabelVoxels voxels;
    voxels.size = image.grid.size;
    voxels.labels.resize(image.grid.voxels());
    return image.visit([&](const auto* values) {
        const auto valueAt = [&](std::size_t i) { return image.value(values[i * image.layers]); };
        std::atomic<std::size_t> inside{0}, unknown{0};
        parallelFor(IndexRange(0, voxels.labels.size(), 65536), [&](const IndexRange& block) {
            std::size_t count = 0, noNumbers = 0;
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                const double value = valueAt(i);
                count += voxels.labels[i] = value >= threshold;
                noNumbers += std::isnan(value);
            }
            inside += count;
            unknown += noNumbers;
        });
        if (unknown > 0)
            callbacks.warn(
                fmt::format("{}: {} of {} voxels are not numbers (nan); they are outside", path,
                            unknown.load(), voxels.labels.size()));
        if (inside == 0 || inside == voxels.labels.size())
            throw InputError(
                fmt::format("{}: {} of its values are {:g} or more; set `threshold` "
                            "to a value between those of bone and of what surrounds it",
                            path, inside == 0 ? "none" : "all", threshold));
        SurfaceNet net = surfaceNet(voxels);
        interpolate(net, voxels, [&](std::size_t a, std::size_t b) {
            const double low = valueAt(a), high = valueAt(b);
            const double share = (threshold - low) / (high - low);
            // A value that is not a number, or exactly the threshold.
            return share >= 0 && share <= 1 ? share : 0.5;
        });
        return surfaceOf(net, image.grid, [](std::uint16_t label) { return label == 1; });
    });
}

}  // namespace vdbpack
