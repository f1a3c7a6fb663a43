#include "vdbpack/image/meta_image.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/image/text_header.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

// Source: the format as MetaIO reads it, https://itk.org/Wiki/ITK/MetaIO/Documentation.

NumberType typeOf(const TextHeader& header, const std::string& path) {
    constexpr std::pair<const char*, NumberType> kTypes[] = {
        {"MET_UCHAR", NumberType::u8},   {"MET_CHAR", NumberType::i8},
        {"MET_USHORT", NumberType::u16}, {"MET_SHORT", NumberType::i16},
        {"MET_UINT", NumberType::u32},   {"MET_INT", NumberType::i32},
        {"MET_FLOAT", NumberType::f32},  {"MET_DOUBLE", NumberType::f64}};
    const std::string name = header.value("elementtype");
    for (const auto& [known, type] : kTypes)
        if (name == known) return type;
    return voxelType(name, path);
}

/// The finite numbers of the first of some keys that the header has. @param count  how many
std::vector<double> numbersOf(const TextHeader& header, std::initializer_list<const char*> keys,
                              std::size_t count, const std::string& path) {
    for (const char* key : keys) {
        if (!header.has(key)) continue;
        const std::string text = header.value(key);
        std::vector<double> numbers;
        Words words(text);
        double number = 0;
        for (std::string_view word = words.next(); !word.empty(); word = words.next())
            if (numbers.size() <= count && parseReal(word, number) && std::isfinite(number))
                numbers.push_back(number);
            else
                throw InputError(fmt::format("{}: {} = {}: not {} numbers; it is damaged", path,
                                             key, quotedExcerpt(text), count));
        if (numbers.size() != count)
            throw InputError(fmt::format("{}: {} = {}: {} numbers, not {}; it is damaged", path,
                                         key, quotedExcerpt(text), numbers.size(), count));
        return numbers;
    }
    return {};
}

std::int64_t wholeOf(const TextHeader& header, const char* key, std::int64_t least,
                     std::int64_t most, std::int64_t otherwise, const std::string& path) {
    if (!header.has(key)) return otherwise;
    std::int64_t value = 0;
    const std::string text = header.value(key);
    if (!parseInteger(text, value) || value < least || value > most)
        throw InputError(fmt::format("{}: {} = {}: not a whole number from {} to {}; it is damaged",
                                     path, key, quotedExcerpt(text), least, most));
    return value;
}

bool isTrue(const TextHeader& header, const char* key) {
    const std::string text = header.value(key);
    return !text.empty() && (text.front() == 'T' || text.front() == 't' || text.front() == '1');
}

ImageGrid gridOf(const TextHeader& header, const std::string& path) {
    const auto n = static_cast<std::size_t>(wholeOf(header, "ndims", 2, 4, 0, path));
    if (n == 0) throw InputError(path + ": has no NDims; it is no image, or damaged");
    const auto sizes = numbersOf(header, {"dimsize"}, n, path);
    if (sizes.empty()) throw InputError(path + ": has no DimSize; it is damaged");
    const auto spacing = numbersOf(header, {"elementspacing", "elementsize"}, n, path);
    const auto origin = numbersOf(header, {"offset", "position", "origin"}, n, path);
    const auto axes =
        numbersOf(header, {"transformmatrix", "rotation", "orientation"}, n * n, path);
    for (const double size : sizes)
        if (!(size >= 1) || size > 65534 || size != std::floor(size))
            throw InputError(
                fmt::format("{}: DimSize = {}: from 1 to 65,534 voxels along each axis can be read",
                            path, quotedExcerpt(header.value("dimsize"))));
    if (n > 3 && sizes[3] > 1)
        throw InputError(fmt::format(
            "{}: has {} dimensions, {:g} values along the fourth; give an image of one volume",
            path, n, sizes[3]));
    ImageGrid grid;
    for (std::size_t d = 0; d < 3; ++d) {
        grid.size[d] = d < n ? static_cast<std::size_t>(sizes[d]) : 1;
        if (d >= n) continue;
        if (!origin.empty()) grid.origin.c[d] = origin[d];
        if (!axes.empty())
            for (std::size_t row = 0; row < 3; ++row)
                grid.step[d].c[row] = row < n ? axes[d * n + row] : 0;
        if (!spacing.empty()) grid.step[d] = grid.step[d] * spacing[d];
    }
    return grid;
}

/// The file with the voxels.
std::string dataFile(const TextHeader& header, const std::string& path) {
    const std::string name = header.value("elementdatafile");
    if (equalsNoCase(name, "local")) return path;
    if (name.empty()) throw InputError(path + ": has no ElementDataFile; it is damaged");
    if (startsWith(name, "LIST") || name.find('%') != std::string::npos)
        throw InputError(
            fmt::format("{}: ElementDataFile = {}: lists and patterns of files are not read; write "
                        "the image as one file",
                        path, quotedExcerpt(name)));
    requireFileName(name);
    return (std::filesystem::path(path).parent_path() / name).string();
}

/// Inflates what follows an offset. @return whether it makes just so many bytes
bool inflateAll(const InputFile& file, std::uint64_t offset, std::byte* to, std::size_t bytes) {
    std::vector<Bytef> packed(static_cast<std::size_t>(file.size() - offset));
    file.readAt(offset, packed.data(), packed.size());
    auto size = static_cast<uLongf>(bytes);
    const int status = ::uncompress(reinterpret_cast<Bytef*>(to), &size, packed.data(),
                                    static_cast<uLong>(packed.size()));
    if (status == Z_MEM_ERROR) throw ResourceError(file.path() + ": no memory to inflate it");
    return status == Z_OK && size == bytes;
}

void swapBytes(std::byte* bytes, std::size_t count, std::size_t width) {
    for (std::size_t i = 0; width > 1 && i < count; i += width)
        std::reverse(bytes + i, bytes + i + width);
}

}  // namespace

Image readMetaImage(const std::string& path, const ImageReadOptions& options) {
    const TextHeader header = readTextHeader(path);
    ImageGrid grid = gridOf(header, path);
    const bool stated = header.has("elementspacing") || header.has("elementsize");
    const double unit = unitFactor(header.value("distanceunits"), path, options.callbacks);
    if (unit > 0) {
        grid.origin *= unit;
        for (Vec<3>& step : grid.step) step *= unit;
    }
    const bool spaced = applySpacing(grid, options, {stated, stated, stated}, path);
    checkAxes(grid, path, options.callbacks);
    if (wholeOf(header, "elementnumberofchannels", 1, 65535, 1, path) != 1)
        throw InputError(path +
                         ": has several values at each voxel, such as colors; convert it to one");
    if (header.has("binarydata") && !isTrue(header, "binarydata"))
        throw InputError(path + ": its voxels are text; write it with BinaryData = True");
    const InputFile file(dataFile(header, path));
    Image image = allocatedImage(path, grid, 1, typeOf(header, path), file.size());
    const std::size_t bytes = image.values() * bytesOf(image.type);
    const std::int64_t skipped =
        wholeOf(header, "headersize", -1, std::numeric_limits<std::int64_t>::max(), 0, path);
    std::uint64_t offset = skipped > 0           ? static_cast<std::uint64_t>(skipped)
                           : file.path() == path ? header.end
                                                 : 0;
    if (skipped < 0) offset = file.size() - std::min<std::uint64_t>(file.size(), bytes);
    options.callbacks.stopIfCancelled();
    const bool packed = isTrue(header, "compresseddata");
    bool whole = offset <= file.size() && (packed || bytes <= file.size() - offset);
    if (whole && packed)
        whole = inflateAll(file, offset, image.bytes.get(), bytes);
    else if (whole)
        file.readAt(offset, image.bytes.get(), bytes);
    if (!whole) throw InputError(file.path() + ": ends before its last voxel" + kDamaged);
    if (isTrue(header, "binarydatabyteordermsb") || isTrue(header, "elementbyteordermsb"))
        swapBytes(image.bytes.get(), bytes, bytesOf(image.type));
    image.isSpaced = spaced;
    image.unit = unit;
    image.format = "MetaImage";
    return image;
}

}  // namespace vdbpack
