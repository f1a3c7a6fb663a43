#include "vdbpack/domain/domain_image.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/pose.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/input_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

namespace vdbpack {

bool isAtBorder(const LabelPart& part, const ImageGrid& grid) {
    Box<3> box;
    for (const LabelCount& label : part.labels) {
        box.add(label.voxelBox.lo);
        box.add(label.voxelBox.hi);
    }
    for (int d = 0; d < 3; ++d)
        if (box.lo[d] < 0.5 ||
            box.hi[d] > static_cast<double>(grid.size[static_cast<std::size_t>(d)]) - 1.5)
            return true;
    return false;
}

void warnOfBorder(const std::vector<LabelPart>& parts, const ImageGrid& grid,
                  const std::string& path, const Callbacks& callbacks) {
    constexpr std::size_t kNamed = 4;
    std::vector<std::string> names;
    for (const LabelPart& part : parts)
        if (isAtBorder(part, grid)) names.push_back(part.name);
    if (names.empty()) return;
    const std::size_t more = names.size() - std::min(names.size(), kNamed);
    names.resize(names.size() - more);
    callbacks.warn(
        fmt::format("{}: label{} {}{} the border of the image, where a flat wall closes {}", path,
                    names.size() + more > 1 ? "s" : "", fmt::join(names, ", "),
                    more > 0           ? fmt::format(" and {} more reach", more)
                    : names.size() > 1 ? " reach"
                                       : " reaches",
                    names.size() + more > 1 ? "each" : "it"));
}

void warnOfBorder(const Image& image, double threshold, const std::string& path,
                  const Callbacks& callbacks) {
    const auto& size = image.grid.size;
    const auto last = [&](std::size_t d) { return std::max<std::size_t>(size[d], 2) - 1; };
    std::size_t cut = 0, at = 0;
    image.visit([&](const auto* numbers) {
        for (std::size_t k = 0; k < size[2]; ++k)
            for (std::size_t j = 0; j < size[1]; ++j, at += size[0]) {
                const bool isFace = k % last(2) == 0 || j % last(1) == 0;
                for (std::size_t i = 0; i < size[0]; i += isFace ? 1 : last(0))
                    cut += image.value(numbers[(at + i) * image.layers]) >= threshold;
            }
    });
    if (cut > 0)
        callbacks.warn(
            fmt::format("{}: {} voxels on the border of the image are not below the "
                        "threshold, {:.6g}; a flat wall closes the surface there",
                        path, cut, threshold));
}

std::vector<LabelCount> requiredLabels(const DomainRecipe& recipe, const Image& image,
                                       const Callbacks& callbacks) {
    const bool asked = !recipe.label.empty();
    if (const auto labels = labelsOf(image, asked)) {
        if (asked && callbacks.warning && !labelsOf(image))
            callbacks.warn(fmt::format(
                "{}: seems to be a grey image, such as a CT, of which label {} has only the voxels "
                "of exactly that value; give the label map, or set `threshold` to the lowest value "
                "of bone",
                recipe.source, recipe.label));
        return *labels;
    }
    throw ParameterError(fmt::format(
        "{}: is no label map, but {}; set `threshold` to the lowest value of bone", recipe.source,
        asked ? "has values that are not whole numbers, or more than 65,000 different ones"
              : "has many different values, as grey images do (`label` takes them for labels)"));
}

LabelPart selectedPart(const DomainRecipe& recipe, const std::vector<LabelCount>& labels) {
    const std::string& path = recipe.source;
    const std::string text = recipe.label.empty() && labels.size() <= 1 ? "all" : recipe.label;
    if (!text.empty()) {
        const auto parts = parseLabels(text, labels, path);
        if (parts.size() == 1) return parts.front();
        throw ParameterError(
            fmt::format("`label` {}: names {} parts, where a single domain is needed; name one "
                        "label, or join them by +",
                        text, parts.size()));
    }
    throw ParameterError(
        fmt::format("{}: has {} labels; set `label` to the one to fill, or several joined by +: {}",
                    path, labels.size(), listOf(labels)));
}

namespace {

/// @param unitOfOther  whether the unit of the recipe is that of another file, which an image that
/// states its own may contradict
Image placedImage(const DomainRecipe& recipe, const Callbacks& callbacks, bool unitOfOther) {
    ImageReadOptions options;
    options.callbacks = callbacks;
    options.spacing = recipe.voxelSpacing;
    Image image = recipe.image ? *recipe.image : readImage(recipe.source, options);
    const double unit = millimetersPer(recipe.unit);
    if (!unitOfOther && image.unit > 0 && unit != 1 && unit != image.unit)
        throw ParameterError(fmt::format(
            "{}: states its unit of length, {:g} mm; `unit` {} contradicts it. Leave `unit` out, "
            "or set `scale` if the file is wrong",
            recipe.source, image.unit, unitName(recipe.unit)));
    const double scale = recipe.scale * (image.unit > 0 ? 1 : unit);
    image.grid.origin *= scale;
    for (Vec<3>& step : image.grid.step) step *= scale;
    if (recipe.space == ImageSpace::ras)
        for (int d = 0; d < 2; ++d) {
            image.grid.origin[d] *= -1;
            for (Vec<3>& step : image.grid.step) step[d] *= -1;
        }
    place(image.grid, recipe, callbacks);
    return image;
}

/// For each voxel of `grid`, whether its center lies in a label of another image, LABEL=FILE.
std::vector<std::uint8_t> maskOver(const ImageGrid& grid, const DomainRecipe& recipe,
                                   const Callbacks& callbacks) {
    const auto equals = recipe.mask.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == recipe.mask.size())
        throw ParameterError("`mask` " + recipe.mask +
                             ": write LABEL=FILE, such as 22=vertebrae.nii.gz");
    DomainRecipe other = recipe;
    other.source = recipe.mask.substr(equals + 1);
    other.label = recipe.mask.substr(0, equals);
    other.image = nullptr;
    requireGreyImage("`mask`", other.source);
    Image image = placedImage(other, callbacks, true);
    roundLabels(image, other.source, callbacks);
    const LabelPart part = [&] {
        try {
            return selectedPart(other, requiredLabels(other, image, callbacks));
        } catch (const ParameterError& error) {
            throw ParameterError("`mask` " + recipe.mask + ": " + error.what());
        }
    }();
    const ImageIndexer indexer(image.grid);
    const Vec<3> first = indexer.indexOf(grid.origin);
    std::vector<std::uint8_t> mask(grid.voxels());
    image.visit([&](const auto* numbers) {
        const auto isIn = [&](const Vec<3>& index) {
            std::size_t at = 0;
            for (std::size_t d = 3; d-- > 0;) {
                const double nearest = std::round(index[static_cast<int>(d)]);
                if (!(nearest >= 0) || nearest >= static_cast<double>(image.grid.size[d]))
                    return false;
                at = at * image.grid.size[d] + static_cast<std::size_t>(nearest);
            }
            return std::any_of(part.labels.begin(), part.labels.end(), [&](const LabelCount& l) {
                return image.value(numbers[at * image.layers + l.layer]) ==
                       static_cast<double>(l.value);
            });
        };
        std::array<Vec<3>, 3> step;
        for (std::size_t d = 0; d < 3; ++d)
            step[d] = indexer.indexOf(grid.origin + grid.step[d]) - first;
        parallelFor(std::size_t(0), grid.size[2], [&](std::size_t k) {
            std::size_t at = k * grid.size[0] * grid.size[1];
            for (std::size_t j = 0; j < grid.size[1]; ++j)
                for (std::size_t i = 0; i < grid.size[0]; ++i)
                    mask[at++] =
                        isIn(first + static_cast<double>(i) * step[0] +
                             static_cast<double>(j) * step[1] + static_cast<double>(k) * step[2]);
        });
    });
    return mask;
}

/// Sets voxels of a label map off the mask to 0.
void applyMask(Image& image, const DomainRecipe& recipe, const Callbacks& callbacks) {
    requiredLabels(recipe, image);
    const auto mask = maskOver(image.grid, recipe, callbacks);
    if (std::find(mask.begin(), mask.end(), 1) == mask.end())
        throw ParameterError(
            fmt::format("`mask` {}: none of its voxels lies in {}; are both of the same scan, in "
                        "the same space?",
                        recipe.mask, recipe.source));
    const std::size_t each = bytesOf(image.type), bytes = image.values() * each;
    const auto kept = image.bytes;  // which others may share
    image.bytes = voxelMemory(bytes);
    if (!image.bytes)
        throw ResourceError(recipe.source + ": there is not enough memory to mask its voxels");
    std::copy_n(kept.get(), bytes, image.bytes.get());
    std::array<std::byte, sizeof(double)> nothing{};
    image.visit([&](const auto* numbers) {
        const auto zero = static_cast<std::decay_t<decltype(*numbers)>>(
            std::round(-image.intercept / image.slope));
        std::memcpy(nothing.data(), &zero, each);
    });
    for (std::size_t n = 0; n < mask.size(); ++n)
        for (std::size_t l = 0; !mask[n] && l < image.layers; ++l)
            std::copy_n(nothing.data(), each, image.bytes.get() + (n * image.layers + l) * each);
}

}  // namespace

Image readDomainImage(const DomainRecipe& recipe, const Callbacks& callbacks) {
    Image image = placedImage(recipe, callbacks, false);
    roundLabels(image, recipe.source, callbacks);
    if (recipe.mask.empty()) return image;
    if (recipe.threshold)
        throw ParameterError("`mask` is for label maps; leave it or `threshold` out");
    applyMask(image, recipe, callbacks);
    return image;
}

void requireGreyImage(const std::string& setting, const std::string& file) {
    if (!namesImage(file))
        throw ParameterError(fmt::format(
            "{}: {} is no image by its name; give .nii, .nii.gz, .nrrd, .mha or a folder of DICOM",
            setting, file));
    requireThere(file);
}

Image readGreyImage(const std::string& file, const DomainRecipe& domain,
                    const Callbacks& callbacks) {
    DomainRecipe recipe;
    recipe.source = file;
    recipe.space = domain.space;
    recipe.voxelSpacing = domain.voxelSpacing;
    if (isImage(domain)) {  // of the same scan
        recipe.unit = domain.unit;
        recipe.scale = domain.scale;
        recipe.pose = domain.pose;
    }
    Image image = placedImage(recipe, callbacks, true);
    if (image.layers != 1)
        throw InputError(file + ": has several values at each voxel; give one layer");
    return image;
}

TriangleMesh imageMesh(DomainRecipe& recipe, const Callbacks& callbacks,
                       std::optional<ImageGrid>& grid, bool& spaced, bool& sided) {
    const Image image = readDomainImage(recipe, callbacks);
    grid = image.grid;
    spaced = image.isSpaced;
    sided = image.isSided;
    callbacks.stopIfCancelled();
    if (recipe.threshold) {
        if (!recipe.label.empty())
            throw ParameterError("`label` and `threshold`: a domain has one of them");
        if (const auto labels = labelsOf(image); labels && labels->size() > 1)
            callbacks.warn(
                fmt::format("{}: seems to be a label map of {} labels, between whose values "
                            "`threshold` has no meaning; set `label`",
                            recipe.source, labels->size()));
        recipe.threshold = recipe.threshold->of(image, recipe.source, callbacks);
        TriangleMesh mesh =
            thresholdSurface(image, *recipe.threshold->value, recipe.source, callbacks);
        warnOfBorder(image, *recipe.threshold->value, recipe.source, callbacks);
        return mesh;
    }
    const auto labels = requiredLabels(recipe, image, callbacks);
    const LabelPart part = selectedPart(recipe, labels);
    warnOfBorder({part}, image.grid, recipe.source, callbacks);
    TriangleMesh mesh = std::move(labelSurfaces(image, labels, {part}).front());
    warnOfVolume(mesh, image.grid, part.voxels(), recipe.source + ": label " + part.name,
                 callbacks);
    return mesh;
}

}  // namespace vdbpack
