#include "vdbpack/preview/picture.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/output_file.h"

#include <fmt/format.h>
#include <png.h>

#include <csetjmp>

namespace vdbpack {

namespace {

/// A higher level takes longer than drawing and saves little.
constexpr int kCompression = 4;

void append(png_structp png, png_bytep data, png_size_t bytes) {
    static_cast<std::string*>(png_get_io_ptr(png))
        ->append(reinterpret_cast<const char*>(data), bytes);
}

void nothingToFlush(png_structp) {}

/// libpng leaves by longjmp, so nothing with a destructor may live here.
bool encode(png_structp png, png_infop info, const Picture& image, png_textp texts, int count,
            std::string& out) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_write_fn(png, &out, append, nothingToFlush);
    png_set_compression_level(png, kCompression);
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
                 static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_text(png, info, texts, count);
    png_write_info(png, info);
    for (int y = 0; y < image.height; ++y) png_write_row(png, image.pixel(0, y));
    png_write_end(png, info);
    return true;
}

}  // namespace

std::string encodePng(const Picture& image) {
    const auto wanted =
        3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (image.width < 1 || image.height < 1 || image.pixels.size() != wanted)
        throw ParameterError(
            fmt::format("picture of {} x {} pixels has {} values; give three per pixel",
                        image.width, image.height, image.pixels.size()));
    std::vector<png_text> texts;
    for (const auto& [keyword, text] : image.texts) {
        png_text t{};
        t.compression = PNG_ITXT_COMPRESSION_NONE;
        t.key = const_cast<char*>(keyword.c_str());
        t.text = const_cast<char*>(text.c_str());
        texts.push_back(t);
    }
    std::string out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    const bool done =
        info && encode(png, info, image, texts.data(), static_cast<int>(texts.size()), out);
    if (png) png_destroy_write_struct(&png, info ? &info : nullptr);
    if (!done) throw ResourceError("picture: libpng cannot encode it; check the available memory");
    return out;
}

void writePng(const Picture& image, const std::string& path) {
    const std::string bytes = encodePng(image);
    OutputFile file(path);
    file.write(bytes);
    file.commit();
}

}  // namespace vdbpack
