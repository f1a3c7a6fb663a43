#include "vdbpack/image/dicom_slices.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/dicom_check.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace vdbpack {

namespace {

// Source: DICOM PS3.3, C.7.6.2 and C.7.6.16 (functional groups), C.8.8.3.2 (offsets of doses),
// C.8.20 (segmentations).
using Items = gdcm::SmartPointer<gdcm::SequenceOfItems>;
const gdcm::Tag kMeasures(0x0028, 0x9110), kOrientation(0x0020, 0x9116), kPosition(0x0020, 0x9113),
    kContent(0x0020, 0x9111), kTransformation(0x0028, 0x9145), kSegment(0x0062, 0x000a);

Items itemsOf(const gdcm::DataSet& set, const gdcm::Tag& tag) {
    return set.FindDataElement(tag) ? set.GetDataElement(tag).GetValueAsSQ() : Items();
}

/// The bytes of an element; empty where it is absent.
std::string_view bytesIn(const gdcm::DataSet& set, const gdcm::Tag& tag) {
    const gdcm::ByteValue* const value =
        set.FindDataElement(tag) ? set.GetDataElement(tag).GetByteValue() : nullptr;
    return value ? std::string_view(value->GetPointer(), value->GetLength()) : std::string_view();
}

/// A number in two bytes, else 0; files in big endian are not read.
std::size_t shortOf(std::string_view bytes) {
    if (bytes.size() != 2) return 0;
    return unsignedNumber(reinterpret_cast<const unsigned char*>(bytes.data()), 2, false);
}

std::string textOf(std::string_view bytes) {
    return std::string(trimmed(bytes.substr(0, bytes.find('\0'))));
}

/// The elements of a file but its pixels.
class DicomHeader {
public:
    explicit DicomHeader(const std::string& file) : file_(file) {
        reader_.SetFileName(file.c_str());
        if (!reader_.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010)))
            throw InputError(file + ": cannot be read as DICOM; it is damaged");
        frames_ = static_cast<std::size_t>(number({0x0028, 0x0008}, 1));
        shared_ = itemsOf(top(), {0x5200, 0x9229});
        own_ = itemsOf(top(), {0x5200, 0x9230});
        if (own_ && own_->GetNumberOfItems() != frames_)
            throw InputError(
                fmt::format("{}: has {} frames, but says of {} where they lie; it is "
                            "damaged",
                            file, frames_, own_->GetNumberOfItems()));
    }

    std::size_t frames() const { return frames_; }
    /// Whether each frame has functional groups.
    bool hasOwnGroups() const { return own_; }

    /// What a frame says in a functional group, else all frames, else the file.
    std::string_view bytes(std::size_t frame, const gdcm::Tag& group, const gdcm::Tag& tag) const {
        for (const bool own : {true, false}) {
            const Items& groups = own ? own_ : shared_;
            const std::size_t item = own ? frame + 1 : 1;
            if (!groups || groups->GetNumberOfItems() < item) continue;
            const Items in = itemsOf(groups->GetItem(item).GetNestedDataSet(), group);
            if (!in || in->GetNumberOfItems() == 0) continue;
            const std::string_view found = bytesIn(in->GetItem(1).GetNestedDataSet(), tag);
            if (!found.empty()) return found;
        }
        return bytesIn(top(), tag);
    }
    std::string text(std::size_t frame, const gdcm::Tag& group, const gdcm::Tag& tag) const {
        return textOf(bytes(frame, group, tag));
    }

    /// Finite numbers; none where so many are not stated. @param count  how many, 0: any
    std::vector<double> numbers(std::size_t frame, const gdcm::Tag& group, const gdcm::Tag& tag,
                                std::size_t count) const {
        std::vector<double> list;
        const std::string found = text(frame, group, tag);
        double value = 0;
        for (const std::string& one : splitAt(found, '\\'))
            if (parseNumber(one, value) && std::isfinite(value)) list.push_back(value);
        if (count > 0 && list.size() != count) list.clear();
        return list;
    }

    /// One number of the file.
    double number(const gdcm::Tag& tag, double otherwise) const {
        const auto list = numbers(0, {}, tag, 1);
        return list.empty() ? otherwise : list.front();
    }

    std::size_t shortNumber(const gdcm::Tag& tag) const { return shortOf(bytes(0, {}, tag)); }
    const gdcm::DataSet& top() const { return reader_.GetFile().GetDataSet(); }

private:
    std::string file_;
    gdcm::Reader reader_;
    std::size_t frames_ = 1;
    Items shared_, own_;
};

Vec<3> vec(const std::vector<double>& v, std::size_t first) {
    return {{v[first], v[first + 1], v[first + 2]}};
}

void setPlace(DicomSlice& slice, const DicomHeader& header) {
    const std::size_t k = slice.frame;
    const auto axes = header.numbers(k, kOrientation, {0x0020, 0x0037}, 6);
    slice.oriented = !axes.empty();
    slice.along = {{{{1, 0, 0}}, {{0, 1, 0}}}};
    if (slice.oriented) slice.along = {normalized(vec(axes, 0)), normalized(vec(axes, 3))};
    // Rows come first in the file, columns in an image.
    const auto pixels = header.numbers(k, kMeasures, {0x0028, 0x0030}, 2);
    if (!pixels.empty()) slice.spacing = {{pixels[1], pixels[0]}};
    const auto between = header.numbers(k, kMeasures, {0x0018, 0x0088}, 1);
    if (!between.empty()) slice.between = std::max(0.0, between[0]);
    const auto position = header.numbers(k, kPosition, {0x0020, 0x0032}, 3);
    slice.placed = !position.empty();
    if (slice.placed) slice.position = vec(position, 0);
}

/// Frames that have no positions of their own lie behind one another.
void setOffsets(std::vector<DicomSlice>& slices, const DicomHeader& header) {
    if (slices.size() < 2 || header.hasOwnGroups()) return;
    const auto offsets = header.numbers(0, {}, {0x3004, 0x000c}, slices.size());
    const double gap = header.number({0x0018, 0x0088}, 0);
    for (std::size_t k = 0; k < slices.size(); ++k) {
        const Vec<3> across = cross(slices[k].along[0], slices[k].along[1]);
        const double offset =
            offsets.empty() ? static_cast<double>(k) * std::max(0.0, gap) : offsets[k] - offsets[0];
        slices[k].position += offset * across;
        slices[k].stacked = offsets.empty() && !(gap > 0);
    }
}

}  // namespace

DicomSegments dicomSegments(const std::string& file) {
    const DicomHeader header(file);
    DicomSegments segments;
    segments.ofBits = header.shortNumber({0x0028, 0x0100}) == 1;
    if (header.text(0, {}, {0x0062, 0x0001}) == "FRACTIONAL")
        segments.whole = std::max(std::size_t{1}, header.shortNumber({0x0062, 0x000e}));
    const Items items = itemsOf(header.top(), {0x0062, 0x0002});
    for (std::size_t i = 1; items && i <= items->GetNumberOfItems(); ++i) {
        const gdcm::DataSet& item = items->GetItem(i).GetNestedDataSet();
        segments.names.push_back(
            {textOf(bytesIn(item, {0x0062, 0x0005})),
             static_cast<std::int64_t>(shortOf(bytesIn(item, {0x0062, 0x0004}))), 0});
    }
    return segments;
}

std::string DicomSlice::name() const {
    return frames > 1 ? fmt::format("{}, frame {}", file, frame + 1) : file;
}

std::vector<DicomSlice> dicomSlices(const std::string& file) {
    const DicomHeader header(file);
    DicomSlice slice;
    slice.file = file;
    slice.frames = header.frames();
    slice.size = {header.shortNumber({0x0028, 0x0011}), header.shortNumber({0x0028, 0x0010})};
    const bool isSigned = header.shortNumber({0x0028, 0x0103}) == 1;
    slice.type = *numberTypeNamed(
        fmt::format("{}{}", isSigned ? "int" : "uint",
                    std::max(std::size_t{8}, header.shortNumber({0x0028, 0x0100}))));
    slice.segmented = isDicomSegmentation(header.text(0, {}, {0x0008, 0x0016}));
    const bool isLabelMap = header.text(0, {}, {0x0062, 0x0001}) == "LABELMAP";
    if (header.shortNumber({0x0028, 0x0002}) > 1 ||
        (startsWith(header.text(0, {}, {0x0028, 0x0004}), "PALETTE") && !slice.segmented))
        throw InputError(file +
                         ": has several values at each pixel, such as colors; convert it to one");
    std::vector<DicomSlice> slices;
    for (slice.frame = 0; slice.frame < slice.frames; ++slice.frame) {
        setPlace(slice, header);
        slice.segment =
            isLabelMap ? 0 : shortOf(header.bytes(slice.frame, kSegment, {0x0062, 0x000b}));
        if (slice.segmented && !isLabelMap && slice.segment == 0)
            throw InputError(slice.name() +
                             ": does not state its segment (ReferencedSegmentNumber); convert the "
                             "file to .nrrd or "
                             ".nii with 3D Slicer or dcmqi's segimage2itkimage");
        slice.stack = header.text(slice.frame, kContent, {0x0020, 0x9056});
        // Also of the kinds of images to which the standard gives no scale but of doses.
        auto slope = header.numbers(slice.frame, kTransformation, {0x0028, 0x1053}, 1);
        if (slope.empty()) slope = header.numbers(slice.frame, {}, {0x3004, 0x000e}, 1);
        const auto intercept = header.numbers(slice.frame, kTransformation, {0x0028, 0x1052}, 1);
        slice.slope = slope.empty() || slope[0] == 0 ? 1 : slope[0];
        slice.intercept = intercept.empty() ? 0 : intercept[0];
        slices.push_back(slice);
    }
    setOffsets(slices, header);
    return slices;
}

}  // namespace vdbpack
