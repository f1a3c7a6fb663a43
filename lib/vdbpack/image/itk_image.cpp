#include "vdbpack/image/itk_image.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/header_checks.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/image/nrrd_grid.h"
#include "vdbpack/image/text_header.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <fstream>
#include <vector>

#if ITK_VERSION_MAJOR > 5 || ITK_VERSION_MINOR >= 4  // the prefix of ITK's own libtiff
#define itk_TIFFSetWarningHandler itk_tiff_TIFFSetWarningHandler
#define itk_TIFFSetErrorHandler itk_tiff_TIFFSetErrorHandler
#endif

// Of the libtiff within ITK, whose headers are not installed.
extern "C" {
using TiffHandler = void (*)(const char* module, const char* format, std::va_list values);
TiffHandler itk_TIFFSetWarningHandler(TiffHandler handler);
TiffHandler itk_TIFFSetErrorHandler(TiffHandler handler);
}

namespace vdbpack {

namespace {

using Io = itk::ImageIOBase::Pointer;

/// The first line of what ITK reports.
std::string causeOf(const itk::ExceptionObject& failure) {
    std::string text = failure.GetDescription();
    // "ITK ERROR: Class(0x...): cause"
    if (const auto at = text.find("): "); at != std::string::npos) text.erase(0, at + 3);
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text.substr(0, 300);
}

/// What ITK does to a file, its exceptions as those of vdb_pack.
template <class Work>
auto byItk(const std::string& path, const Work& work) {
    itk::Object::GlobalWarningDisplayOff();
    itk_TIFFSetWarningHandler(nullptr);
    itk_TIFFSetErrorHandler(nullptr);
    try {
        return work();
    } catch (const itk::MemoryAllocationError&) {
        throw ResourceError(path + ": its voxels take more memory than there is");
    } catch (const itk::ExceptionObject& failure) {
        throw InputError(fmt::format("{}: cannot be read as an image: {}", path, causeOf(failure)));
    }
}

Io ioOf(const std::string& path) {
    const std::string extension = extensionOf(path);
    if (extension == ".nrrd" || extension == ".nhdr") return itk::NrrdImageIO::New().GetPointer();
    return itk::TIFFImageIO::New().GetPointer();
}

/// An io that knows the header of a file.
Io opened(const std::string& path) {
    if (isTiff(path)) checkTiffPages(path);
    return byItk(path, [&] {
        Io io = ioOf(path);
        io->SetFileName(path);
        if (!std::ifstream(path, std::ios::binary))
            throw IoError(path + ": cannot be opened for reading");
        io->ReadImageInformation();
        return io;
    });
}

NumberType typeOf(const itk::ImageIOBase& io, const std::string& path) {
    // Such as "unsigned_char".
    const std::string name = itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType());
    const bool real = name == "float" || name == "double";
    const char* const kind = real ? "float" : startsWith(name, "unsigned") ? "uint" : "int";
    return voxelType(fmt::format("{}{}", kind, 8 * io.GetComponentSize()), path);
}

/// Voxels along each axis, with one slice if it is flat.
std::array<std::size_t, 3> sizeOf(const itk::ImageIOBase& io, const std::string& path) {
    const unsigned dimensions = io.GetNumberOfDimensions();
    for (unsigned d = 3; d < dimensions; ++d)
        if (io.GetDimensions(d) > 1)
            throw InputError(fmt::format(
                "{}: has {} dimensions, {} values along the fourth; give an image of one volume",
                path, dimensions, io.GetDimensions(3)));
    std::array<std::size_t, 3> size{1, 1, 1};
    for (unsigned d = 0; d < std::min(3u, dimensions); ++d) size[d] = io.GetDimensions(d);
    return size;
}

/// Sets the spacing of a TIFF, whose tags state the resolution of paper or of screens rather than
/// of scans. @return false: the file states none
bool applyTiffSpacing(ImageGrid& grid, const itk::ImageIOBase& io, const ImageReadOptions& options,
                      const std::string& path) {
    if (!options.spacing && (io.GetSpacing(0) != 1 || io.GetSpacing(1) != 1))
        options.callbacks.warn(fmt::format(
            "{}: its resolution tags say {:.6g} x {:.6g} mm a pixel, which are seldom the scan's "
            "and are not used",
            path, io.GetSpacing(0), io.GetSpacing(1)));
    return applySpacing(grid, options, {false, false, false}, path);
}

/// Values of each voxel. ITK takes grey pixels in tiles or of one bit for red, green, blue and
/// opacity, where all three are the grey value.
std::size_t layersOf(const itk::ImageIOBase& io, const std::string& path) {
    const std::size_t layers = io.GetNumberOfComponents();
    if (!isTiff(path) || layers == 1 || checkTiffPages(path).isGrey())
        return isTiff(path) ? 1 : layers;
    throw InputError(fmt::format(
        "{}: has {} values at each pixel, such as colors; convert it to one", path, layers));
}

/// @param to  of `count` voxels
void readVoxels(itk::ImageIOBase& io, const std::string& path, std::size_t count, std::byte* to) {
    const std::size_t colors = isTiff(path) ? io.GetNumberOfComponents() : 1;
    const auto wide = voxelMemory(colors > 1 ? count * colors : 0);
    if (!wide) throw ResourceError(path + ": its pixels take more memory than there is");
    byItk(path, [&] {
        itk::ImageIORegion region(io.GetNumberOfDimensions());
        for (unsigned d = 0; d < io.GetNumberOfDimensions(); ++d) {
            region.SetIndex(d, 0);
            region.SetSize(d, io.GetDimensions(d));
        }
        io.SetIORegion(region);
        io.Read(colors > 1 ? wide.get() : to);
        return 0;
    });
    if (colors == 1) return;
    // Where 0 is white, colors are the other way round.
    const auto white = static_cast<std::byte>(checkTiffPages(path).color == 0 ? 255 : 0);
    for (std::size_t i = 0; i < count; ++i) to[i] = wide[i * colors] ^ white;
}

/// One file of a stack.
struct Page {
    std::string file;
    Io io;
    std::array<std::size_t, 3> size{};
};

void requireAlike(const Page& page, const Page& first) {
    if (page.size[2] != 1)
        throw InputError(page.file + ": has several pages; give it alone, or files of one slice");
    if (page.size != first.size)
        throw InputError(fmt::format(
            "{}: has {} x {} pixels, {} has {} x {}; give slices of one series", page.file,
            page.size[0], page.size[1], first.file, first.size[0], first.size[1]));
    layersOf(*page.io, page.file);
}

}  // namespace

Image readByItk(const std::string& path, const ImageReadOptions& options) {
    const bool tiff = isTiff(path);
    TextHeader header;
    if (!tiff) {
        header = readTextHeader(path);
        checkNrrdHeader(header, path);
    }
    const Io io = opened(path);
    ImageGrid grid;
    double unit = 0;
    if (!tiff) grid = nrrdGrid(header, io->GetNumberOfDimensions(), path, options.callbacks, unit);
    grid.size = sizeOf(*io, path);
    if (grid.size[2] <= 1 && tiff)
        throw InputError(path + ": is a single slice; give the folder of all slices");
    const bool spaced = tiff ? applyTiffSpacing(grid, *io, options, path)
                             : applySpacing(grid, options, {true, true, true}, path);
    checkAxes(grid, path, options.callbacks);
    Image image = allocatedImage(path, grid, layersOf(*io, path), typeOf(*io, path),
                                 tiff ? sizeOf(path) : bytesOfData(header, path));
    options.callbacks.stopIfCancelled();
    readVoxels(*io, path, grid.voxels(), image.bytes.get());
    image.names = labelNames(header);
    image.isSpaced = spaced;
    image.isSided = !tiff && namesSides(header);
    image.unit = unit;
    image.format = tiff ? "TIFF" : "NRRD";
    return image;
}

Image readTiffStack(const std::vector<std::string>& files, const ImageReadOptions& options) {
    std::vector<Page> pages;
    std::uint64_t bytes = 0;
    for (const std::string& file : files) {
        options.callbacks.stopIfCancelled();
        const Io io = opened(file);
        pages.push_back({file, io, sizeOf(*io, file)});
        requireAlike(pages.back(), pages.front());
        bytes += sizeOf(file);
    }
    ImageGrid grid;
    grid.size = pages.front().size;
    grid.size[2] = pages.size();
    const bool spaced = applyTiffSpacing(grid, *pages.front().io, options, files.front());
    const auto typeAt = [&](std::size_t z) { return typeOf(*pages[z].io, pages[z].file); };
    NumberType type = typeAt(0);
    for (std::size_t z = 1; z < pages.size(); ++z)
        if (typeAt(z) != typeAt(0)) type = NumberType::f32;
    Image image = allocatedImage(files.front(), grid, 1, type, bytes);
    const std::size_t pixels = grid.size[0] * grid.size[1];
    for (std::size_t z = 0; z < pages.size(); ++z) {
        options.callbacks.stopIfCancelled();
        std::byte* const to = image.bytes.get() + z * pixels * bytesOf(type);
        if (typeAt(z) == type) {
            readVoxels(*pages[z].io, pages[z].file, pixels, to);
            continue;
        }
        const auto own = voxelMemory(pixels * bytesOf(typeAt(z)));
        if (!own)
            throw ResourceError(pages[z].file + ": its pixels take more memory than there is");
        readVoxels(*pages[z].io, pages[z].file, pixels, own.get());
        toFloats(typeAt(z), own, pixels, 1, 0, reinterpret_cast<float*>(to));
    }
    image.format = "TIFF";
    image.isSpaced = spaced;
    image.isSided = false;
    return image;
}

}  // namespace vdbpack
