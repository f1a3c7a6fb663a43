#include "vdbpack/image/header_checks.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <set>
#include <string_view>

namespace vdbpack {

bool isTiff(const std::string& path) {
    const std::string extension = extensionOf(path);
    return extension == ".tif" || extension == ".tiff";
}

namespace {

/// Takes what an entry of a page says of its pixels.
void takeEntry(const InputFile& file, std::uint64_t at, bool bigEndian, bool big,
               TiffPixels& pixels) {
    const std::uint64_t tag = file.numberAt(at, 2, bigEndian);
    const std::size_t width = file.numberAt(at + 2, 2, bigEndian) == 3 ? 2 : 4;
    const std::uint64_t value = file.numberAt(at + (big ? 12 : 8), width, bigEndian);
    if (tag == 258) pixels.bits = value;
    if (tag == 262) pixels.color = value;
    if (tag == 277) pixels.samples = value;
    if (tag == 339) pixels.number = value;
    if (tag == 322) pixels.tiled = true;
}

/// Refuses grey pixels that ITK would take for colors or not read at all.
void requireReadable(const InputFile& file, const TiffPixels& p) {
    if (!p.isGrey() || p.bits == 1 || (p.bits == 8 && (p.number == 1 || !p.tiled))) return;
    if (p.tiled)
        file.fail(fmt::format(
            "is tiled and has {} bits a pixel, where tiles are read of 1 and 8; rewrite it "
            "in strips (`tiffcp -s`)",
            p.bits));
    if (p.bits != 16 && p.bits != 32 && p.bits != 64)
        file.fail(fmt::format("has {} bits a pixel; convert it to 8 or 16", p.bits));
}

}  // namespace

TiffPixels checkTiffPages(const std::string& path) {
    constexpr std::size_t kMostPages = 65535;
    const InputFile file(path);
    char mark[2] = {};
    if (file.size() >= 8) file.readAt(0, mark, 2);
    const bool bigEndian = mark[0] == 'M';
    const std::string_view begin(mark, 2);
    if (begin != "II" && begin != "MM") file.fail("is no TIFF image");
    // BigTIFF has longer counts and offsets.
    const bool big = file.numberAt(2, 2, bigEndian) == 43;
    const std::size_t width = big ? 8 : 4;
    std::uint64_t offset = file.numberAt(big ? 8 : 4, width, bigEndian);
    std::set<std::uint64_t> pages;
    TiffPixels pixels;
    while (offset != 0) {
        if (!pages.insert(offset).second || pages.size() > kMostPages)
            file.failAtByte(offset, "pages refer to each other in a circle; it is damaged");
        const std::uint64_t entries = file.numberAt(offset, big ? 8 : 2, bigEndian);
        if (entries > 65535) file.failAtByte(offset, "a page has too many entries; it is damaged");
        offset += big ? 8 : 2;
        const std::uint64_t size = big ? 20 : 12;
        for (std::uint64_t i = 0; pages.size() == 1 && i < entries; ++i)
            takeEntry(file, offset + i * size, bigEndian, big, pixels);
        offset = file.numberAt(offset + entries * size, width, bigEndian);
    }
    requireReadable(file, pixels);
    return pixels;
}

std::array<bool, 3> checkNiftiHeader(const std::string& path) {
    const auto fail = [&](const std::string& what) {
        throw InputError(
            fmt::format("{}: {}; it is no NIfTI image, or its header is damaged", path, what));
    };
    std::array<unsigned char, 540> header{};
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
    if (!file) throw IoError(path + ": cannot be opened for reading");
    const int there = gzread(file.get(), header.data(), header.size());
    const auto size = [&](bool order) { return unsignedNumber(header.data(), 4, order); };
    const bool bigEndian = size(true) == 348 || size(true) == 540;
    const bool second = size(bigEndian) == 540;
    if ((size(bigEndian) != 348 && !second) || there < (second ? 540 : 348))
        fail("its header does not begin with 348 or 540");
    const std::size_t width = second ? 8 : 2;
    const unsigned char* const dims = header.data() + (second ? 16 : 40);
    const std::uint64_t count = unsignedNumber(dims, width, bigEndian);
    if (count < 1 || count > 7) fail(fmt::format("it has {} dimensions", count));
    for (std::uint64_t d = 1; d <= count; ++d) {
        const std::uint64_t n = unsignedNumber(dims + d * width, width, bigEndian);
        if (n < 1 || n > 0x7fff'ffff || (!second && n > 0x7fff))
            fail(fmt::format("it has {} voxels along axis {}", n, d));
    }
    constexpr int kTypes[] = {2,   4,   8,    16,   32,   64,   128,  256,
                              512, 768, 1024, 1280, 1536, 1792, 2048, 2304};
    const auto type =
        static_cast<int>(unsignedNumber(header.data() + (second ? 12 : 70), 2, bigEndian));
    if (std::find(std::begin(kTypes), std::end(kTypes), type) == std::end(kTypes))
        fail(fmt::format("its data type is {}", type));
    const auto real = [&](std::size_t at) {
        const std::uint64_t bits = unsignedNumber(header.data() + at, second ? 8 : 4, bigEndian);
        const auto half = static_cast<std::uint32_t>(bits);
        double wide = 0;
        float narrow = 0;
        std::memcpy(&wide, &bits, 8);
        std::memcpy(&narrow, &half, 4);
        return second ? wide : static_cast<double>(narrow);
    };
    const double begin = second ? static_cast<double>(static_cast<std::int64_t>(
                                      unsignedNumber(header.data() + 168, 8, bigEndian)))
                                : real(108);
    if (!(begin >= 0 && begin < 1e9)) fail(fmt::format("its voxels begin at byte {:g}", begin));
    std::array<bool, 3> spaced{};
    for (std::size_t d = 0; d < 3; ++d) {
        const double distance = real(second ? 112 + 8 * d : 80 + 4 * d);
        spaced[d] = std::isfinite(distance) && distance != 0;
    }
    return spaced;
}

}  // namespace vdbpack
