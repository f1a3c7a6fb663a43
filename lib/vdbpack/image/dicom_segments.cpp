#include "vdbpack/image/dicom_segments.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/dicom.h"
#include "vdbpack/image/dicom_check.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/io/input_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

namespace vdbpack {

namespace {

constexpr const char* kSeveral =
    "; the file has several volumes: write each into a file of its own";

double heightOf(const DicomSlice& slice) {
    return dot(slice.position, cross(slice.along[0], slice.along[1]));
}

/// One slice at each position of the frames, and empty ones where they leave gaps.
std::vector<DicomSlice> slicesAt(std::vector<DicomSlice> frames) {
    constexpr double kSame = 1e-3, kMostSlices = 65534;
    std::sort(frames.begin(), frames.end(),
              [](const DicomSlice& a, const DicomSlice& b) { return heightOf(a) < heightOf(b); });
    std::vector<DicomSlice> found{frames.front()};
    for (const DicomSlice& frame : frames)
        if (heightOf(frame) - heightOf(found.back()) > kSame) found.push_back(frame);
    std::vector<double> gaps;
    for (std::size_t k = 1; k < found.size(); ++k)
        gaps.push_back(heightOf(found[k]) - heightOf(found[k - 1]));
    // Positions decide: the stated distance counts if all of them follow it.
    double step = found.front().between;
    const auto isWhole = [&](double gap) {
        return gap > 0.5 * step && std::fabs(gap / step - std::round(gap / step)) < 0.05;
    };
    if (!gaps.empty() && !(step > 0 && std::all_of(gaps.begin(), gaps.end(), isWhole)))
        step = *std::min_element(gaps.begin(), gaps.end());
    const DicomSlice &first = found.front(), &last = found.back();
    if (heightOf(last) - heightOf(first) > kMostSlices * step) return found;
    if (gaps.empty() && step > 0) {
        found.push_back(first);
        found.back().position += step * cross(found[0].along[0], found[0].along[1]);
        return found;
    }
    std::vector<DicomSlice> slices{found.front()};
    for (std::size_t k = 0; k < gaps.size(); ++k) {
        const Vec<3> way = found[k + 1].position - found[k].position;
        const double steps = isWhole(gaps[k]) ? std::round(gaps[k] / step) : 1;
        for (double i = 1; i <= steps; ++i) {
            slices.push_back(found[k + 1]);
            slices.back().position = found[k].position + (i / steps) * way;
        }
    }
    return slices;
}

/// The pixels of a file of segments, and where they belong.
class Segments {
public:
    /// @param slices  at all positions, sorted
    Segments(const std::vector<DicomSlice>& frames, const std::vector<DicomSlice>& slices,
             const std::string& path, const ImageReadOptions& options)
        : meaning_(dicomSegments(frames.front().file)),
          pixels_(frames.front().size[0] * frames.front().size[1]),
          wide_(bytesOf(frames.front().type) == 2) {
        const DicomSlice& any = frames.front();
        if (bytesOf(any.type) > 2)
            throw InputError(path + ": its pixels are of 32 bits, which segmentations do not have");
        // GDCM does not know all segmentations.
        const std::uint64_t begin = checkDicom(any.file).pixels;
        const std::size_t bits = meaning_.ofBits ? 1 : 8 * bytesOf(any.type);
        bytes_.resize(begin > 0 ? (pixels_ * any.frames * bits + 7) / 8 : 0);
        if (begin > 0)
            InputFile(any.file).readAt(begin, bytes_.data(), bytes_.size());
        else
            bytes_ = pixelsOf(any);
        if (meaning_.whole > 1)
            options.callbacks.warn(fmt::format(
                "{}: its segments are fractions of voxels; voxels of {} of {} or more are taken",
                path, (meaning_.whole + 1) / 2, meaning_.whole));
        for (const DicomSlice& frame : frames) {
            requireAlike(frame, slices.front());
            const auto above = std::upper_bound(
                slices.begin() + 1, slices.end(), heightOf(frame) + 1e-6,
                [](double height, const DicomSlice& slice) { return height < heightOf(slice); });
            const auto [other, isNew] = frames_[frame.segment].emplace(
                static_cast<std::size_t>(above - slices.begin()) - 1, frame.frame);
            if (length(frame.position - std::prev(above)->position) > 0.1 * frame.spacing[0] &&
                frame.spacing[0] > 0)
                throw InputError(frame.name() + ": lies beside other frames at its height" +
                                 kSeveral);
            if (!isNew)
                throw InputError(fmt::format(
                    "{}: lies at the position of frame {}, which has the same segment{}",
                    frame.name(), other->second + 1, kSeveral));
        }
    }

    /// Calls `work(voxel, label)` for the voxels of a segment, until it returns false.
    template <class Work>
    bool forEachVoxel(std::size_t segment, const Work& work) const {
        for (const auto& [slice, frame] : frames_.at(segment))
            for (std::size_t i = 0; i < pixels_; ++i) {
                const std::size_t pixel = frame * pixels_ + i;
                if (const std::size_t label = labelAt(pixel, segment)) {
                    if (!work(slice * pixels_ + i, label)) return false;
                } else if (meaning_.ofBits && bytes_[pixel / 8] == 0) {
                    i += 7 - pixel % 8;  // nor have the others of the byte
                }
            }
        return true;
    }

    std::vector<std::size_t> numbers() const {
        std::vector<std::size_t> all;
        for (const auto& [segment, frames] : frames_) all.push_back(segment);
        return all;
    }
    const std::vector<LabelName>& names() const { return meaning_.names; }

private:
    std::size_t labelAt(std::size_t pixel, std::size_t segment) const {
        if (meaning_.ofBits) return bytes_[pixel / 8] >> pixel % 8 & 1 ? segment : 0;
        std::uint16_t number = 0;
        std::memcpy(&number, &bytes_[wide_ ? 2 * pixel : pixel], wide_ ? 2 : 1);
        if (segment == 0) return number;
        return number > 0 && 2 * std::size_t{number} >= meaning_.whole ? segment : 0;
    }

    DicomSegments meaning_;
    std::size_t pixels_;
    bool wide_;
    std::vector<char> bytes_;
    std::map<std::size_t, std::map<std::size_t, std::size_t>> frames_;  // of segments, by slice
};

}  // namespace

Image readSegments(const std::string& path, const std::vector<DicomSlice>& frames,
                   const ImageReadOptions& options) {
    std::vector<DicomSlice> plain = frames;
    for (DicomSlice& frame : plain) {
        frame.stack.clear();
        if (frame.file != frames.front().file)
            throw InputError(fmt::format(
                "{}: is a segmentation among other files; give the file alone", frames[0].file));
    }
    std::vector<DicomSlice> slices = slicesAt(plain);
    if (!frames.front().placed || slices.size() == 1)
        throw InputError(
            path +
            ": does not state the positions of its frames, or of a single slice the "
            "distance to the next one (SpacingBetweenSlices); convert it to .nrrd with 3D Slicer");
    bool isSpaced = true;
    const ImageGrid grid = gridOfSlices(slices, options, path, isSpaced);
    const Segments segments(plain, slices, path, options);
    const std::uint64_t bytes = sizeOf(frames.front().file);
    // Each segment goes into the first layer where it overlaps none before it.
    const Image taken = allocatedImage(path, grid, 1, NumberType::u8, bytes);
    std::vector<std::size_t> rest = segments.numbers();
    std::map<std::size_t, std::size_t> layers;
    std::size_t count = 0;
    for (; !rest.empty(); ++count) {
        std::fill_n(taken.bytes.get(), grid.voxels(), std::byte{0});
        std::vector<std::size_t> later;
        for (const std::size_t segment : rest) {
            options.callbacks.stopIfCancelled();
            const bool isFree = segments.forEachVoxel(segment, [&](std::size_t voxel, std::size_t) {
                return taken.bytes[voxel] == std::byte{0};
            });
            if (!isFree) {
                later.push_back(segment);
                continue;
            }
            layers[segment] = count;
            segments.forEachVoxel(segment, [&](std::size_t voxel, std::size_t) {
                taken.bytes[voxel] = std::byte{1};
                return true;
            });
        }
        rest = later;
    }
    Image image = allocatedImage(path, grid, count, NumberType::u16, bytes);
    auto* const numbers = reinterpret_cast<std::uint16_t*>(image.bytes.get());
    std::fill_n(numbers, image.values(), std::uint16_t{0});
    for (const auto& [segment, layer] : layers)
        segments.forEachVoxel(segment, [&, at = layer](std::size_t voxel, std::size_t label) {
            numbers[voxel * count + at] = static_cast<std::uint16_t>(label);
            return true;
        });
    image.names = segments.names();
    for (LabelName& name : image.names)
        if (const auto at = layers.find(static_cast<std::size_t>(name.value)); at != layers.end())
            name.layer = at->second;
    image.format = "DICOM segmentation";
    image.isSpaced = isSpaced;
    image.isSided = frames.front().oriented;
    return image;
}

}  // namespace vdbpack
