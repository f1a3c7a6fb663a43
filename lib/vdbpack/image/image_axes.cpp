#include "vdbpack/image/image_axes.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>

namespace vdbpack {

namespace {

/// Cosines between axes that count as rounding, and those that are worth a word.
constexpr double kRounding = 1e-3, kWorthAWord = 1e-5;
/// No common compression makes a file smaller than this share of its content (deflate: 1/1032).
constexpr double kMostCompression = 1100;

/// The perpendicular directions nearest to three others.
/// Source: the iteration of Higham (1986), "Computing the polar decomposition",
/// doi:10.1137/0907079: the mean of a matrix and its inverse transposed.
std::array<Vec<3>, 3> perpendicular(std::array<Vec<3>, 3> a) {
    for (int round = 0; round < 20; ++round) {
        const double volume = dot(a[0], cross(a[1], a[2]));
        const std::array<Vec<3>, 3> inverse{cross(a[1], a[2]) * (1 / volume),
                                            cross(a[2], a[0]) * (1 / volume),
                                            cross(a[0], a[1]) * (1 / volume)};
        for (std::size_t i = 0; i < 3; ++i) a[i] = 0.5 * (a[i] + inverse[i]);
    }
    return a;
}

}  // namespace

NumberType voxelType(const std::string& name, const std::string& path) {
    const auto type = numberTypeNamed(name);
    if (!type || (!isReal(*type) && bytesOf(*type) > 4))
        throw InputError(fmt::format(
            "{}: its voxels are of type {}; convert it to integers of at most 32 bits or to floats",
            path, quotedExcerpt(name)));
    return *type;
}

std::uint64_t sizeOf(const std::string& path) {
    std::error_code failed;
    const auto size = std::filesystem::file_size(path, failed);
    if (failed) throw IoError(fmt::format("{}: cannot be read: {}", path, failed.message()));
    return size;
}

bool applySpacing(ImageGrid& grid, const ImageReadOptions& options, std::array<bool, 3> known,
                  const std::string& path) {
    std::string missing;
    for (std::size_t d = 0; d < 3; ++d) {
        Vec<3>& step = grid.step[d];
        const double size = length(step);
        const bool sound = size > 0 && std::isfinite(size);
        if (known[d] && sound) continue;
        missing += missing.empty() ? "axis " : ", ";
        missing += std::to_string(d + 1);
        if (!sound) {
            step = {};
            step.c[d] = 1;
        }
        if (options.spacing) step = normalized(step) * options.spacing->c[d];
    }
    if (!missing.empty() && !options.spacing)
        throw InputError(
            fmt::format("{}: does not say how far its voxels are apart along {}; set "
                        "`voxelSpacing`",
                        path, missing));
    return missing.empty();
}

double unitFactor(const std::string& unit, const std::string& path, const Callbacks& callbacks) {
    struct Known {
        double factor;
        std::initializer_list<const char*> names;
    };
    static const Known kKnown[] = {
        {1, {"mm", "millimeter", "millimetre"}},
        {1e-3, {"um", "\u00b5m", "\u03bcm", "micron", "micrometer", "micrometre"}},
        {1e-6, {"nm", "nanometer", "nanometre"}},
        {10, {"cm", "centimeter", "centimetre"}},
        {1000, {"m", "meter", "metre"}}};
    std::string name = lowered(unit);
    if (name.empty() || name == "?" || name == "???" || name == "none") return 0;
    for (const auto& [factor, names] : kKnown)
        for (const std::string known : names) {
            if (name != known && name != known + 's') continue;
            if (factor != 1)
                callbacks.warn(
                    fmt::format("{}: states lengths in {}; they are multiplied by {:g} "
                                "to mm",
                                path, unit, factor));
            return factor;
        }
    callbacks.warn(
        fmt::format("{}: states lengths in {}, which is no known unit; they are taken "
                    "as mm",
                    path, quotedExcerpt(unit)));
    return 0;
}

void checkAxes(ImageGrid& grid, const std::string& path, const Callbacks& callbacks) {
    const Vec<3> spacing = grid.spacing();
    std::array<Vec<3>, 3> unit;
    for (int d = 0; d < 3; ++d) {
        if (!(spacing[d] > 0) || !std::isfinite(spacing[d]))
            throw InputError(
                fmt::format("{}: the voxels are {:g} x {:g} x {:g} mm apart; set `voxelSpacing`",
                            path, spacing[0], spacing[1], spacing[2]));
        const auto k = static_cast<std::size_t>(d);
        unit[k] = grid.step[k] * (1 / spacing[d]);
    }
    if (!isFinite(grid.origin))
        throw InputError(path + ": the position of its first voxel is not a number");
    if (std::fabs(dot(unit[0], cross(unit[1], unit[2]))) < 1e-3)
        throw InputError(
            path + ": its axes lie in one plane; write the image again, with axes that span space");
    const double skew =
        std::max({std::fabs(dot(unit[0], unit[1])), std::fabs(dot(unit[1], unit[2])),
                  std::fabs(dot(unit[2], unit[0]))});
    if (skew > kRounding)
        callbacks.warn(
            fmt::format("{}: its axes are sheared by {:.2g} degrees, and are taken as they are; "
                        "programs that cannot do so show the image otherwise",
                        path, std::asin(std::min(1.0, skew)) * 180 / 3.14159265358979323846));
    if (skew > kRounding || skew == 0) return;
    if (skew > kWorthAWord)
        callbacks.warn(fmt::format(
            "{}: its axes are perpendicular only up to {:.1e}, and were made so", path, skew));
    unit = perpendicular(unit);
    for (std::size_t k = 0; k < 3; ++k) grid.step[k] = unit[k] * spacing.c[k];
}

double cornersApart(const ImageGrid& a, const ImageGrid& b) {
    double largest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        Vec<3> index;
        for (int d = 0; d < 3; ++d)
            index[d] =
                corner >> d & 1 ? static_cast<double>(a.size[static_cast<std::size_t>(d)]) - 1 : 0;
        largest = std::max(largest, length(a.at(index) - b.at(index)));
    }
    const Vec<3> s = a.spacing();
    return largest / std::min({s[0], s[1], s[2]});
}

void toFloats(NumberType type, const std::shared_ptr<std::byte[]>& from, std::size_t count,
              double slope, double intercept, float* to) {
    Image image;
    image.type = type;
    image.bytes = from;
    image.slope = slope;
    image.intercept = intercept;
    image.visit([&](const auto* numbers) {
        for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<float>(image.value(numbers[i]));
    });
}

Image allocatedImage(const std::string& path, const ImageGrid& grid, std::size_t layers,
                     NumberType type, std::uint64_t fileBytes) {
    const auto& size = grid.size;
    double count = static_cast<double>(bytesOf(type)) * static_cast<double>(layers);
    for (const std::size_t n : size) {
        if (n < 1 || n > 65534)
            throw InputError(fmt::format(
                "{}: has {} x {} x {} voxels; from 1 to 65,534 along each axis can be read", path,
                size[0], size[1], size[2]));
        count *= static_cast<double>(n);
    }
    if (count > kMostCompression * static_cast<double>(fileBytes))
        throw InputError(
            fmt::format("{}: says that it has {} x {} x {} voxels, which a file of {} bytes cannot "
                        "hold{}",
                        path, size[0], size[1], size[2], fileBytes, kDamaged));
    Image image;
    image.grid = grid;
    image.layers = layers;
    image.type = type;
    // Not set to 0: pages that a truncated file does not fill are never used.
    image.bytes = voxelMemory(static_cast<std::size_t>(count));
    if (!image.bytes)
        throw ResourceError(fmt::format(
            "{}: its {} x {} x {} voxels take {:.3g} GB of memory, which are not available", path,
            size[0], size[1], size[2], count / 1e9));
    return image;
}

}  // namespace vdbpack
