#include "vdbpack/image/dicom.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/dicom_check.h"
#include "vdbpack/image/dicom_segments.h"
#include "vdbpack/image/dicom_slices.h"
#include "vdbpack/image/image_axes.h"

#include <fmt/format.h>
#include <gdcmImageReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <vector>

namespace vdbpack {

namespace {

/// The files of the one series in a folder.
std::vector<std::string> seriesIn(const std::string& folder, const ImageReadOptions& options) {
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
    if (series.empty())
        throw InputError(folder +
                         ": has no DICOM image files, no .tif files and no masks (.nii .nii.gz "
                         ".nrrd .mha)");
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

/// "0, 2, 10 mm"
std::string positionsOf(const std::vector<double>& along) {
    constexpr std::size_t kMost = 24;
    std::string text;
    for (std::size_t k = 0; k < std::min(kMost, along.size()); ++k)
        text += fmt::format("{}{:.5g}", k > 0 ? ", " : "", along[k]);
    return text + (along.size() > kMost ? ", ... mm" : " mm");
}

/// Sorts slices by position, and refuses them unless they are evenly spaced on a line.
/// @return from each to the next one
Vec<3> sortAlong(std::vector<DicomSlice>& slices, const Vec<3>& across) {
    const auto height = [&](const DicomSlice& s) { return dot(s.position, across); };
    std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
        return height(a) < height(b);
    });
    const auto gaps = static_cast<double>(slices.size() - 1);
    const DicomSlice& first = slices.front();
    const Vec<3> step = (slices.back().position - first.position) * (1 / gaps);
    std::vector<double> along;
    for (const DicomSlice& s : slices) along.push_back(height(s));
    const double mean = (along.back() - along.front()) / gaps;
    for (std::size_t k = 1; k < slices.size(); ++k) {
        const DicomSlice &slice = slices[k], &last = slices[k - 1];
        const double gap = along[k] - along[k - 1];
        if (!(gap > 1e-6))
            throw InputError(
                fmt::format("{} and {}: lie at the same position; give the slices of one volume",
                            last.name(), slice.name()));
        if (std::fabs(gap - mean) > 0.05 * mean)
            throw InputError(fmt::format(
                "{} and {}: are {:.4g} mm apart, slices of this series {:.4g} mm on average; a "
                "slice is missing, or they are not evenly spaced: resample the series. Its slices "
                "lie at {}",
                last.name(), slice.name(), gap, mean, positionsOf(along)));
        const Vec<3> off = slice.position - first.position - static_cast<double>(k) * step;
        const double aside = length(off - dot(off, across) * across);
        if (aside > 0.1 * std::max(first.spacing[0], first.spacing[1]))
            throw InputError(fmt::format(
                "{}: lies {:.4g} mm beside the line through the first and the last slice; "
                "resample the series",
                slice.name(), aside));
    }
    return step;
}

/// Reads the pixels of one file into the slices of an image.
/// @param numbers  of its slices among `slices`
void readFile(const std::vector<DicomSlice>& slices, const std::vector<std::size_t>& numbers,
              Image& image) {
    const DicomSlice& any = slices[numbers.front()];
    const std::size_t pixels = any.size[0] * any.size[1];
    const std::size_t bytes = pixels * bytesOf(any.type);
    const auto own = voxelMemory(bytes);
    if (!own) throw ResourceError(any.file + ": its pixels take more memory than there is");
    const std::vector<char> buffer = pixelsOf(any);
    for (const std::size_t z : numbers) {
        const char* const from = buffer.data() + slices[z].frame * bytes;
        std::byte* const to = image.bytes.get() + z * pixels * bytesOf(image.type);
        if (image.type == any.type) {
            std::memcpy(to, from, bytes);
            continue;
        }
        std::memcpy(own.get(), from, bytes);
        toFloats(any.type, own, pixels, slices[z].slope, slices[z].intercept,
                 reinterpret_cast<float*>(to));
    }
}

}  // namespace

void requireAlike(const DicomSlice& slice, const DicomSlice& first) {
    if (slice.size != first.size)
        throw InputError(
            fmt::format("{}: has {} x {} pixels, {} has {} x {}; give slices of one "
                        "series",
                        slice.name(), slice.size[0], slice.size[1], first.name(), first.size[0],
                        first.size[1]));
    for (std::size_t axis = 0; axis < 2; ++axis)
        if (length(slice.along[axis] - first.along[axis]) > 1e-3 ||
            std::fabs(slice.spacing.c[axis] - first.spacing.c[axis]) > 1e-3 * first.spacing.c[axis])
            throw InputError(
                fmt::format("{}: its pixels and the pixels of {} do not lie along the same axes; "
                            "give slices of one series",
                            slice.name(), first.name()));
    if (slice.stack != first.stack)
        throw InputError(fmt::format(
            "{}: is of stack {}, {} of stack {}; the file has several volumes: write each into a "
            "file of its own",
            slice.name(), slice.stack, first.name(), first.stack));
    if (slice.placed != first.placed || slice.oriented != first.oriented)
        throw InputError(fmt::format(
            "{} and {}: one of them does not state where it lies; give slices of one series",
            first.name(), slice.name()));
}

ImageGrid gridOfSlices(std::vector<DicomSlice>& slices, const ImageReadOptions& options,
                       const std::string& path, bool& isSpaced) {
    const DicomSlice first = slices.front();
    for (const DicomSlice& slice : slices) requireAlike(slice, first);
    if (slices.size() == 1)
        throw InputError(path + ": is a single slice; give the folder of all slices");
    if (!first.placed && first.frames < slices.size())
        throw InputError(first.name() +
                         ": does not state its position (ImagePositionPatient); write the slices "
                         "as one file of another format, or as a TIFF stack");
    if (!first.placed || !first.oriented)
        options.callbacks.warn(
            path +
            ": does not state position and directions: where it lies and which side is left is "
            "unknown");
    const Vec<3> across = normalized(cross(first.along[0], first.along[1]));
    ImageGrid grid;
    grid.step = {first.along[0], first.along[1], across};
    if (!first.stacked) grid.step[2] = sortAlong(slices, across);
    grid.origin = slices.front().position;
    grid.size = {first.size[0], first.size[1], slices.size()};
    std::array<bool, 3> known{false, false, !first.stacked};
    for (std::size_t d = 0; d < 2; ++d)
        if ((known[d] = first.spacing.c[d] > 0)) grid.step[d] *= first.spacing.c[d];
    isSpaced = applySpacing(grid, options, known, path);
    checkAxes(grid, path, options.callbacks);
    return grid;
}

std::vector<char> pixelsOf(const DicomSlice& any) {
    gdcm::ImageReader reader;
    reader.SetFileName(any.file.c_str());
    std::vector<char> buffer(any.size[0] * any.size[1] * bytesOf(any.type) * any.frames);
    if (!reader.Read() || reader.GetImage().GetBufferLength() != buffer.size() ||
        reader.GetImage().GetPixelFormat().GetPixelSize() != bytesOf(any.type) ||
        !reader.GetImage().GetBuffer(buffer.data()))
        throw InputError(any.file +
                         ": its pixels cannot be decoded; convert it to explicit little "
                         "endian (1.2.840.10008.1.2.1)");
    return buffer;
}

Image readDicom(const std::string& path, const ImageReadOptions& options) {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    std::error_code ignored;
    const bool folder = std::filesystem::is_directory(path, ignored);
    if (!folder && !checkDicom(path).image) throw InputError(path + ": is no DICOM image");
    std::vector<DicomSlice> slices;
    std::uint64_t bytes = 0;
    for (const std::string& file : folder ? seriesIn(path, options) : std::vector{path}) {
        options.callbacks.stopIfCancelled();
        for (const DicomSlice& slice : dicomSlices(file)) slices.push_back(slice);
        bytes += sizeOf(file);
    }
    if (slices.front().segmented) return readSegments(path, slices, options);
    bool isSpaced = true;
    const ImageGrid grid = gridOfSlices(slices, options, path, isSpaced);
    const DicomSlice& first = slices.front();
    const bool alike = std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& s) {
        return s.type == first.type && s.slope == first.slope && s.intercept == first.intercept;
    });
    Image image = allocatedImage(path, grid, 1, alike ? first.type : NumberType::f32, bytes);
    std::map<std::string, std::vector<std::size_t>> files;
    for (std::size_t z = 0; z < slices.size(); ++z) files[slices[z].file].push_back(z);
    for (const auto& [file, numbers] : files) {
        options.callbacks.stopIfCancelled();
        readFile(slices, numbers, image);
    }
    if (alike) {
        image.slope = first.slope;
        image.intercept = first.intercept;
    }
    image.format = "DICOM";
    image.isSpaced = isSpaced;
    image.isSided = first.oriented;
    return image;
}

}  // namespace vdbpack
