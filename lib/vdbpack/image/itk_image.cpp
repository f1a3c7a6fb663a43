#include "vdbpack/image/itk_image.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/dicom_check.h"
#include "vdbpack/image/header_checks.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/image/text_header.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <filesystem>
#include <fstream>
#include <map>
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
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
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
    if (extension == ".tif" || extension == ".tiff") return itk::TIFFImageIO::New().GetPointer();
    return itk::GDCMImageIO::New().GetPointer();
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

/// The grid that an io reports, with one slice if it is flat.
ImageGrid gridOf(const itk::ImageIOBase& io, const std::string& path) {
    const unsigned dimensions = io.GetNumberOfDimensions();
    for (unsigned d = 3; d < dimensions; ++d)
        if (io.GetDimensions(d) > 1)
            throw InputError(fmt::format(
                "{}: has {} dimensions, {} values along the fourth; give an image of one volume",
                path, dimensions, io.GetDimensions(3)));
    ImageGrid grid;
    for (unsigned d = 0; d < 3; ++d) {
        grid.size[d] = d < dimensions ? io.GetDimensions(d) : 1;
        if (d >= dimensions) continue;
        grid.origin.c[d] = io.GetOrigin(d);
        const std::vector<double> direction = io.GetDirection(d);
        for (unsigned row = 0; row < 3; ++row)
            grid.step[d].c[row] = row < direction.size() ? direction[row] * io.GetSpacing(d) : 0;
    }
    return grid;
}

void readVoxels(itk::ImageIOBase& io, const std::string& path, std::byte* to) {
    byItk(path, [&] {
        itk::ImageIORegion region(io.GetNumberOfDimensions());
        for (unsigned d = 0; d < io.GetNumberOfDimensions(); ++d) {
            region.SetIndex(d, 0);
            region.SetSize(d, io.GetDimensions(d));
        }
        io.SetIORegion(region);
        io.Read(to);
        return 0;
    });
}

/// One file of a series.
struct Slice {
    std::string file;
    Io io;
    ImageGrid grid;
    double along = 0;  // mm, across the slices
};

/// Reads slices one after another into an image of `grid`. Where they are stored as numbers of
/// different types, as DICOM with different scales may be, as floats.
Image joined(const std::vector<Slice>& slices, const ImageGrid& grid, const std::string& path,
             const ImageReadOptions& options) {
    NumberType type = typeOf(*slices.front().io, slices.front().file);
    std::uint64_t bytes = 0;
    bool alike = true;
    for (const Slice& slice : slices) {
        bytes += sizeOf(slice.file);
        alike = alike && typeOf(*slice.io, slice.file) == type;
        if (slice.io->GetNumberOfComponents() != 1)
            throw InputError(
                slice.file +
                ": has several values at each pixel, such as colors; convert it to one");
    }
    if (!alike) type = NumberType::f32;
    Image image = allocatedImage(path, grid, 1, type, bytes);
    const std::size_t pixels = grid.size[0] * grid.size[1];
    for (std::size_t z = 0; z < slices.size(); ++z) {
        options.callbacks.stopIfCancelled();
        const Slice& slice = slices[z];
        std::byte* const to = image.bytes.get() + z * pixels * bytesOf(type);
        if (alike) {
            readVoxels(*slice.io, slice.file, to);
            continue;
        }
        Image own = allocatedImage(slice.file, slice.grid, 1, typeOf(*slice.io, slice.file), bytes);
        readVoxels(*slice.io, slice.file, own.bytes.get());
        own.visit([&](const auto* numbers) {
            auto* const floats = reinterpret_cast<float*>(to);
            for (std::size_t i = 0; i < pixels; ++i) floats[i] = static_cast<float>(numbers[i]);
        });
    }
    return image;
}

void requireAlike(const Slice& slice, const Slice& first) {
    if (slice.grid.size[0] != first.grid.size[0] || slice.grid.size[1] != first.grid.size[1])
        throw InputError(
            fmt::format("{}: has {} x {} pixels, {} has {} x {}; give slices of one series",
                        slice.file, slice.grid.size[0], slice.grid.size[1], first.file,
                        first.grid.size[0], first.grid.size[1]));
}

std::vector<Slice> openedSlices(const std::vector<std::string>& files,
                                const ImageReadOptions& options) {
    std::vector<Slice> slices;
    for (const std::string& file : files) {
        options.callbacks.stopIfCancelled();
        const Io io = opened(file);
        slices.push_back({file, io, gridOf(*io, file)});
    }
    return slices;
}

/// The slices of the one series in a folder.
std::vector<std::string> slicesIn(const std::string& folder, const ImageReadOptions& options) {
    std::map<std::string, std::vector<std::string>> series;
    std::error_code failed;
    for (const auto& entry : std::filesystem::directory_iterator(folder, failed)) {
        options.callbacks.stopIfCancelled();
        std::error_code ignored;
        if (!entry.is_regular_file(ignored)) continue;
        const DicomKind kind = checkDicom(entry.path().string());
        if (kind.image) series[kind.series].push_back(entry.path().string());
    }
    if (failed) throw IoError(fmt::format("{}: cannot be read: {}", folder, failed.message()));
    if (series.empty()) throw InputError(folder + ": has no DICOM image files and no .tif files");
    std::string list;
    for (auto& [id, files] : series) {
        std::sort(files.begin(), files.end());
        list += fmt::format("\n  {} files, such as {}", files.size(), files.front());
    }
    if (series.size() > 1)
        throw InputError(
            fmt::format("{}: has {} series of images; move each into a folder of its own:{}",
                        folder, series.size(), list));
    return series.begin()->second;
}

}  // namespace

Image readByItk(const std::string& path, const ImageReadOptions& options) {
    const std::string extension = extensionOf(path);
    const bool nrrd = extension == ".nrrd" || extension == ".nhdr";
    const bool tiff = isTiff(path);
    TextHeader header;
    if (nrrd) {
        header = readTextHeader(path);
        checkNrrdHeader(header, path);
    } else if (!tiff && !checkDicom(path).image) {
        throw InputError(path + ": is no DICOM image");
    }
    const Io io = opened(path);
    ImageGrid grid = gridOf(*io, path);
    const bool spaced =
        nrrd ? header.has("space directions") || header.has("spacings") : !tiff && grid.size[2] > 1;
    if (grid.size[2] <= 1 && !nrrd)
        throw InputError(path + ": is a single slice; give the folder of all slices");
    applySpacing(grid, options, spaced, path);
    if (nrrd && !header.has("space") && !header.has("space dimension"))
        options.callbacks.warn(
            path + ": does not say in which space its axes lie: which side is left is unknown");
    checkAxes(grid, path, options.callbacks);
    Image image = allocatedImage(path, grid, io->GetNumberOfComponents(), typeOf(*io, path),
                                 nrrd ? bytesOfData(header, path) : sizeOf(path));
    if (!nrrd && image.layers > 1)
        throw InputError(
            fmt::format("{}: has {} values at each voxel, such as colors; convert it to one", path,
                        image.layers));
    options.callbacks.stopIfCancelled();
    readVoxels(*io, path, image.bytes.get());
    image.names = labelNames(header);
    image.isSpaced = spaced;
    image.format = nrrd ? "NRRD" : tiff ? "TIFF" : "DICOM";
    return image;
}

Image readDicomFolder(const std::string& folder, const ImageReadOptions& options) {
    const std::vector<std::string> files = slicesIn(folder, options);
    if (files.size() == 1) return readByItk(files.front(), options);
    std::vector<Slice> slices = openedSlices(files, options);
    const Slice& any = slices.front();
    const Vec<3> across = normalized(cross(any.grid.step[0], any.grid.step[1]));
    for (Slice& slice : slices) {
        requireAlike(slice, any);
        for (std::size_t axis = 0; axis < 2; ++axis)
            if (length(slice.grid.step[axis] - any.grid.step[axis]) >
                1e-3 * length(any.grid.step[axis]))
                throw InputError(fmt::format(
                    "{}: its pixels do not lie along those of {}; give slices of one series",
                    slice.file, any.file));
        slice.along = dot(slice.grid.origin, across);
    }
    std::sort(slices.begin(), slices.end(),
              [](const Slice& a, const Slice& b) { return a.along < b.along; });
    const Slice &first = slices.front(), &last = slices.back();
    const auto gaps = static_cast<double>(slices.size() - 1);
    ImageGrid grid = first.grid;
    grid.size[2] = slices.size();
    grid.step[2] = (last.grid.origin - first.grid.origin) * (1 / gaps);
    const double mean = (last.along - first.along) / gaps;
    for (std::size_t k = 1; k < slices.size(); ++k) {
        const double gap = slices[k].along - slices[k - 1].along;
        if (!(gap > 1e-6))
            throw InputError(
                fmt::format("{} and {}: lie at the same position; give the slices of one volume",
                            slices[k - 1].file, slices[k].file));
        if (std::fabs(gap - mean) > 0.05 * mean)
            throw InputError(fmt::format(
                "{} and {}: are {:.4g} mm apart, slices of this series {:.4g} mm on average; a "
                "slice is missing, or they are not evenly spaced: resample the series",
                slices[k - 1].file, slices[k].file, gap, mean));
    }
    checkAxes(grid, folder, options.callbacks);
    Image image = joined(slices, grid, folder, options);
    image.format = "DICOM";
    return image;
}

Image readTiffStack(const std::vector<std::string>& files, const ImageReadOptions& options) {
    const std::vector<Slice> slices = openedSlices(files, options);
    for (const Slice& slice : slices) {
        if (slice.grid.size[2] != 1)
            throw InputError(slice.file +
                             ": has several pages; give it alone, or files of one slice");
        requireAlike(slice, slices.front());
    }
    ImageGrid grid = slices.front().grid;
    grid.size[2] = slices.size();
    applySpacing(grid, options, false, files.front());
    Image image = joined(slices, grid, files.front(), options);
    image.format = "TIFF";
    image.isSpaced = false;
    return image;
}

}  // namespace vdbpack
