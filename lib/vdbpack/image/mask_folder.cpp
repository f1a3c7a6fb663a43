#include "vdbpack/image/mask_folder.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

namespace vdbpack {

namespace {

/// The file's name without folder and extension.
std::string maskName(const std::string& file) {
    std::string name = std::filesystem::path(file).filename().string();
    if (extensionOf(name) == ".gz") name.resize(name.size() - 3);
    name.resize(name.size() - extensionOf(name).size());
    return name;
}

/// Refuses a mask that does not lie in the voxels of the first one.
void requireGrid(const Image& mask, const std::string& file, const Image& first,
                 const std::string& firstFile) {
    constexpr double kMostApart = 0.05;  // voxels, above what headers of 32 bits round
    const auto &a = mask.grid.size, &b = first.grid.size;
    if (mask.layers != 1)
        throw InputError(file + ": has several values at each voxel; a mask has one");
    if (a != b)
        throw InputError(fmt::format(
            "{}: has {} x {} x {} voxels, {} has {} x {} x {}; masks of a folder lie on one grid",
            file, a[0], a[1], a[2], firstFile, b[0], b[1], b[2]));
    if (const double apart = cornersApart(first.grid, mask.grid); apart > kMostApart)
        throw InputError(fmt::format(
            "{}: lies {:.3g} voxels from {}; masks of a folder lie on one grid: resample it", file,
            apart, firstFile));
}

/// The value of a mask where it is not 0; 0 for an empty one.
double valueOf(const Image& mask, const std::string& file) {
    return mask.visit([&](const auto* numbers) {
        double found = 0;
        for (std::size_t i = 0; i < mask.values(); ++i) {
            const double value = mask.value(numbers[i]);
            if (value == 0 || value == found) continue;
            if (found != 0)
                throw InputError(fmt::format(
                    "{}: has the values 0, {:g} and {:g}, and a mask has 0 and one more; take it "
                    "out of the folder, or give this file alone",
                    file, found, value));
            found = value;
        }
        return found;
    });
}

/// Writes a label into the first layer where its mask overlaps no other label. @return its number
std::size_t addTo(std::vector<Image>& layers, const Image& mask, std::uint16_t label,
                  const std::string& file) {
    return mask.visit([&](const auto* numbers) {
        const auto isIn = [&](std::size_t i) { return mask.value(numbers[i]) != 0; };
        const std::size_t voxels = mask.grid.voxels();
        for (std::size_t at = 0;; ++at) {
            if (at == layers.size()) {
                layers.push_back(allocatedImage(file, mask.grid, 1, NumberType::u16, 2 * voxels));
                std::memset(layers.back().bytes.get(), 0, 2 * voxels);
            }
            auto* const labels = reinterpret_cast<std::uint16_t*>(layers[at].bytes.get());
            std::size_t i = 0;
            while (i < voxels && !(labels[i] != 0 && isIn(i))) ++i;
            if (i < voxels) continue;
            for (i = 0; i < voxels; ++i)
                if (isIn(i)) labels[i] = label;
            return at;
        }
    });
}

/// Layers of one value a voxel as one image.
Image joined(const std::vector<Image>& layers, const std::string& folder) {
    if (layers.size() == 1) return layers.front();
    const std::size_t voxels = layers.front().grid.voxels(), count = layers.size();
    Image image =
        allocatedImage(folder, layers.front().grid, count, NumberType::u16, 2 * voxels * count);
    auto* const to = reinterpret_cast<std::uint16_t*>(image.bytes.get());
    for (std::size_t at = 0; at < count; ++at) {
        const auto* const from = reinterpret_cast<const std::uint16_t*>(layers[at].bytes.get());
        for (std::size_t i = 0; i < voxels; ++i) to[i * count + at] = from[i];
    }
    return image;
}

}  // namespace

bool namesMask(const std::string& path) {
    const std::string extension = extensionOf(path);
    for (const char* other : {".nii", ".nrrd", ".nhdr", ".mha", ".mhd"})
        if (extension == other) return true;
    return endsWith(lowered(path), ".nii.gz");
}

Image readMasks(const std::vector<std::string>& files, const std::string& folder,
                const ImageReadOptions& options) {
    std::vector<Image> layers;
    Image first;  // without its voxels
    std::vector<LabelName> names;
    std::vector<std::string> empty;
    ImageReadOptions each = options;
    for (std::size_t k = 0; k < files.size(); ++k) {
        options.callbacks.stopIfCancelled();
        Image mask = readImage(files[k], each);
        if (k == 0) {
            first = mask;
            first.bytes = nullptr;
            each.callbacks.warning = nullptr;  // which would warn of the same grid again
        }
        requireGrid(mask, files[k], first, files.front());
        const std::string name = maskName(files[k]);
        if (valueOf(mask, files[k]) == 0) {
            empty.push_back(name);
            continue;
        }
        const auto label = static_cast<std::uint16_t>(k + 1);
        names.push_back({name, label, addTo(layers, mask, label, files[k])});
    }
    if (layers.empty())
        throw InputError(
            fmt::format("{}: its {} masks are empty, all voxels are 0", folder, files.size()));
    constexpr std::size_t kMostNamed = 8;
    const std::size_t named = std::min(empty.size(), kMostNamed), more = empty.size() - named;
    if (!empty.empty())
        options.callbacks.warn(fmt::format(
            "{}: empty masks are left out, {} of {}: {}{}", folder, empty.size(), files.size(),
            fmt::join(empty.begin(), empty.begin() + static_cast<std::ptrdiff_t>(named), ", "),
            more > 0 ? fmt::format(" and {} more", more) : ""));
    Image image = joined(layers, folder);
    image.names = std::move(names);
    image.format = fmt::format("{} masks, {}", files.size(), first.format);
    image.isSpaced = first.isSpaced;
    image.isSided = first.isSided;
    image.unit = first.unit;
    return image;
}

}  // namespace vdbpack
