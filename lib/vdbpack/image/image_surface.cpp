#include "vdbpack/image/image_surface.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace vdbpack {

namespace {

/// `LabelVoxels` count by 16 bits.
constexpr std::size_t kMostLabels = 65000;
/// Whole numbers below it are exact.
constexpr double kLargestLabel = 9e15;
/// Of more labels than these, what neighbors have tells whether they are grey values.
constexpr std::size_t kFewLabels = 20;
/// Voxels around a selection that are looked at with it: its neighbors shape its surface.
constexpr std::size_t kMargin = 3;

/// What rows of a layer have.
struct Tally {
    std::map<std::int64_t, LabelCount> counts;
    bool whole = true;  ///< and no more values than labels can be
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
        if (!(std::fabs(value) < kLargestLabel) || value != std::floor(value)) {
            tally.whole = false;
            return;
        }
        if (value != 0) {
            LabelCount& label = tally.counts[static_cast<std::int64_t>(value)];
            label.voxels += end - x;
            ++label.stretches;
            const auto y = static_cast<double>(row % size[1]);
            const auto z = static_cast<double>(row / size[1]);
            label.voxelBox.add({{static_cast<double>(x), y, z}});
            label.voxelBox.add({{static_cast<double>(end - 1), y, z}});
            if (tally.counts.size() > kMostLabels) tally.whole = false;
        }
        x = end;
    }
}

/// The labels of a layer in every `stride`-th row.
Tally tallyOf(const Image& image, std::size_t layer, std::size_t stride) {
    const std::size_t rows = (image.grid.size[1] * image.grid.size[2] + stride - 1) / stride;
    PerThread<Tally> tallies;
    image.visit([&](const auto* numbers) {
        parallelFor(IndexRange(0, rows, 64), [&](const IndexRange& block) {
            Tally& mine = tallies.local();
            for (std::size_t row = block.begin(); row < block.end() && mine.whole; ++row)
                addRow(image, numbers, layer, row * stride, mine);
        });
    });
    Tally all;
    for (const Tally& mine : tallies) {
        all.whole = all.whole && mine.whole;
        for (const auto& [value, count] : mine.counts) {
            LabelCount& label = all.counts[value];
            label.value = value;
            label.layer = layer;
            label.voxels += count.voxels;
            label.stretches += count.stretches;
            label.voxelBox.add(count.voxelBox.lo);
            label.voxelBox.add(count.voxelBox.hi);
        }
    }
    all.whole = all.whole && all.counts.size() <= kMostLabels;
    return all;
}

bool seemsGrey(const Image& image, const Tally& tally) {
    if (tally.counts.size() < 2) return false;
    const bool rescaled = !image.isRounded && (image.slope != 1 || image.intercept != 0);
    if (rescaled || tally.counts.begin()->first < -1) return true;
    if (tally.counts.size() <= kFewLabels) return false;
    Box<3> whole;
    for (const auto& [value, label] : tally.counts) {
        whole.add(label.voxelBox.lo);
        whole.add(label.voxelBox.hi);
    }
    const auto voxelsIn = [](const Box<3>& box) {
        return (box.size()[0] + 1) * (box.size()[1] + 1) * (box.size()[2] + 1);
    };
    std::size_t seldom = 0, wide = 0;
    for (const auto& [value, label] : tally.counts) {
        seldom += label.voxels < 2 * label.stretches;
        wide += voxelsIn(label.voxelBox) > 0.5 * voxelsIn(whole);
    }
    return 2 * std::max(seldom, wide) > tally.counts.size();
}

/// A value in a layer.
std::string textOf(const LabelCount& label) {
    return fmt::format("{}@{}", label.value, label.layer);
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
    std::vector<std::string> names;
    for (const LabelCount& label : labels) names.push_back(label.name);
    if (found.empty())
        throw ParameterError(fmt::format(
            "`label` {}: {} has no such label{}; it has {}. Names with , or + are given by value",
            text, path, similarWord(text, names), listOf(labels)));
    throw ParameterError(
        fmt::format("`label` {}: {} has {} of them; {} is the first. The labels are {}", text, path,
                    found.size(), textOf(*found.front()), listOf(labels)));
}

}  // namespace

std::string listOf(const std::vector<LabelCount>& labels) {
    constexpr std::size_t kMost = 40;
    std::string text;
    for (std::size_t i = 0; i < std::min(labels.size(), kMost); ++i) {
        text += (i > 0 ? ", " : "") + std::to_string(labels[i].value);
        if (!labels[i].name.empty()) text += " (" + labels[i].name + ")";
    }
    return labels.size() > kMost ? fmt::format("{} and {} more", text, labels.size() - kMost)
                                 : text;
}

void roundLabels(Image& image, const std::string& path, const Callbacks& callbacks) {
    constexpr std::size_t kMostRounded = 1000;
    const bool isReal = image.type == NumberType::f32 || image.type == NumberType::f64;
    if (!isReal && image.slope == 1 && image.intercept == 0) return;
    std::set<double> values;
    image.visit([&](const auto* numbers) {
        for (std::size_t i = 0; i < image.values() && values.size() <= kMostRounded; ++i)
            if (i == 0 || !(numbers[i] == numbers[i - 1])) {
                const double value = image.value(numbers[i]);
                values.insert(std::isfinite(value) ? value : 0.5);
            }
    });
    if (values.empty() || values.size() > kMostRounded) return;
    const double range = *values.rbegin() - *values.begin();
    const double most = std::min(0.1, range / 510);
    double worst = 0, last = *values.begin() - 1;
    for (const double value : values) {
        const double off = std::fabs(value - std::round(value));
        // Two values of one label are but for the rounding of floats the same.
        const bool same = std::round(value) == std::round(last) && value - last > 1e-5 * range;
        if (off > most || same) return;
        if (off > std::fabs(worst - std::round(worst))) worst = value;
        last = value;
    }
    if (worst == 0) return;
    image.isRounded = true;
    callbacks.warn(fmt::format(
        "{}: its values are whole numbers up to {:.2g}, such as {:.6g}; they are rounded to labels",
        path, std::fabs(worst - std::round(worst)), worst));
}

std::optional<std::vector<LabelCount>> labelsOf(const Image& image, bool asked) {
    /// Rows of a layer that are looked at first: most grey images end there.
    constexpr std::size_t kFirstRows = 4096;
    const std::size_t rows = image.grid.size[1] * image.grid.size[2];
    std::vector<LabelCount> labels;
    for (std::size_t layer = 0; layer < image.layers; ++layer)
        for (const std::size_t stride : {rows / kFirstRows + 1, std::size_t{1}}) {
            const Tally tally = tallyOf(image, layer, stride);
            const bool known = asked || !image.names.empty();
            if (!tally.whole || (!known && seemsGrey(image, tally))) return std::nullopt;
            if (stride > 1) continue;
            for (const auto& [value, label] : tally.counts) labels.push_back(label);
            break;
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
    const double a = image.value(numbers.first), b = image.value(numbers.second);
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
        std::map<std::string, std::size_t> uses;
        for (const LabelCount& label : labels) ++uses[nameOf(label)];
        for (const LabelCount& label : labels) {
            const std::string name = nameOf(label);
            parts.push_back(
                {uses[name] > 1 ? fmt::format("{} ({})", name, textOf(label)) : name, {label}});
        }
        return parts;
    }
    std::vector<const LabelCount*> used;
    for (const std::string& one : splitAt(text, ',')) {
        LabelPart part;
        for (const std::string& name : splitAt(one, '+')) {
            const LabelCount& label = labelOf(name, labels, path);
            part.name += (part.name.empty() ? "" : "+") + (label.name.empty() ? name : label.name);
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

void warnOfVolume(const TriangleMesh& mesh, const ImageGrid& grid, std::size_t voxels,
                  const std::string& what, const Callbacks& callbacks) {
    constexpr double kMost = 0.1;
    double volume = 0;
    for (const auto& t : mesh.triangles) {
        const auto at = [&](std::size_t k) { return mesh.vertices[t[k]] - grid.origin; };
        volume += dot(at(0), cross(at(1), at(2))) / 6;
    }
    const double right = static_cast<double>(voxels) * std::fabs(grid.signedVoxelVolume());
    if (std::fabs(volume - right) > kMost * right)
        callbacks.warn(fmt::format(
            "{}: the surface encloses {:.5g} mm³, its {} voxels {:.5g} mm³ ({:+.0f} %): it has "
            "parts as thin as a voxel. Resample the image to smaller voxels, or make a label map, "
            "whose surface keeps the volume of its voxels",
            what, volume, voxels, right, 100 * (volume / right - 1)));
}

TriangleMesh thresholdSurface(const Image& image, double threshold, const std::string& path,
                              const Callbacks& callbacks) {
    LabelVoxels voxels;
    voxels.size = image.grid.size;
    voxels.labels.resize(image.grid.voxels());
    const std::pair<double, double> range = valueRange(image);
    return image.visit([&](const auto* values) {
        const auto valueAt = [&](std::size_t i) { return image.value(values[i * image.layers]); };
        std::atomic<std::size_t> inside{0}, unknown{0}, between{0};
        parallelFor(IndexRange(0, voxels.labels.size(), 65536), [&](const IndexRange& block) {
            std::size_t count = 0, noNumbers = 0, others = 0;
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                const double value = valueAt(i);
                count += voxels.labels[i] = value >= threshold;
                noNumbers += std::isnan(value);
                others += value > range.first && value < range.second;
            }
            inside += count;
            unknown += noNumbers;
            between += others;
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
        if (between == 0) {
            smooth(net, voxels.size);
        } else {
            interpolate(net, voxels, [&](std::size_t a, std::size_t b) {
                const double low = valueAt(a), high = valueAt(b);
                const double share = (threshold - low) / (high - low);
                // Not at a voxel: around one that has just the threshold, vertices would be one.
                return share >= 0 && share <= 1 ? std::clamp(share, 0.01, 0.99) : 0.5;
            });
        }
        TriangleMesh mesh =
            surfaceOf(net, image.grid, [](std::uint16_t label) { return label == 1; });
        warnOfVolume(mesh, image.grid, inside, fmt::format("{}: `threshold` {:g}", path, threshold),
                     callbacks);
        return mesh;
    });
}

}  // namespace vdbpack
