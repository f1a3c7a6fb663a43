// DICOM files made by tests, in explicit little endian.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack::test {

inline std::string littleEndian(std::size_t number, std::size_t bytes) {
    std::string text;
    for (; bytes > 0; --bytes, number >>= 8) text.push_back(static_cast<char>(number & 0xff));
    return text;
}
inline std::string dicomShort(std::size_t number) {
    return littleEndian(number, 2);
}

/// Elements by group and number, encoded.
class DicomElements {
public:
    DicomElements& set(int group, int number, const std::string& vr, std::string value) {
        if (value.size() % 2 != 0) value.push_back(vr == "UI" ? '\0' : ' ');
        const bool wide = vr == "OW" || vr == "SQ";
        elements_[{group, number}] = dicomShort(static_cast<std::size_t>(group)) +
                                     dicomShort(static_cast<std::size_t>(number)) + vr +
                                     std::string(wide ? 2 : 0, '\0') +
                                     littleEndian(value.size(), wide ? 4 : 2) + value;
        return *this;
    }
    DicomElements& setItems(int group, int number, const std::vector<DicomElements>& items) {
        std::string value;
        for (const DicomElements& item : items)
            value += dicomShort(0xfffe) + dicomShort(0xe000) +
                     littleEndian(item.bytes().size(), 4) + item.bytes();
        return set(group, number, "SQ", value);
    }
    DicomElements& erase(int group, int number) {
        elements_.erase({group, number});
        return *this;
    }
    std::string bytes() const {
        std::string all;
        for (const auto& [tag, bytes] : elements_) all += bytes;
        return all;
    }
    std::string file() const { return std::string(128, '\0') + "DICM" + bytes(); }

private:
    std::map<std::pair<int, int>, std::string> elements_;
};

/// A slice of 2 x 2 pixels of CT at a height; its numbers are `pixels`, of 16 bits.
inline DicomElements dicomSlice(const std::string& height, const std::string& pixels = "12345678") {
    DicomElements slice;
    return slice.set(2, 0x10, "UI", "1.2.840.10008.1.2.1")
        .set(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2")
        .set(0x20, 0xe, "UI", "1.2")
        .set(0x20, 0x32, "DS", "0\\0\\" + height)
        .set(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")
        .set(0x28, 2, "US", dicomShort(1))
        .set(0x28, 4, "CS", "MONOCHROME2")
        .set(0x28, 0x10, "US", dicomShort(2))
        .set(0x28, 0x11, "US", dicomShort(2))
        .set(0x28, 0x30, "DS", "1\\1")
        .set(0x28, 0x100, "US", dicomShort(16))
        .set(0x28, 0x101, "US", dicomShort(16))
        .set(0x28, 0x102, "US", dicomShort(15))
        .set(0x28, 0x103, "US", dicomShort(0))
        .set(0x7fe0, 0x10, "OW", pixels);
}

/// A frame of an enhanced file: its functional groups.
inline DicomElements dicomFrame(const std::string& height, const std::string& stack = "1") {
    DicomElements frame, position, content;
    position.set(0x20, 0x32, "DS", "10\\20\\" + height);
    content.set(0x20, 0x9056, "SH", stack);
    return frame.setItems(0x20, 0x9113, {position}).setItems(0x20, 0x9111, {content});
}

/// An enhanced CT of 2 x 2 pixels a frame, 0.5 x 0.7 mm apart; the pixels of frame k are 100 k to
/// 100 k + 3, and each value is 2 * number - 1000.
inline DicomElements dicomFrames(const std::vector<DicomElements>& frames) {
    DicomElements measures, axes, scale, shared;
    measures.set(0x28, 0x30, "DS", "0.7\\0.5");
    axes.set(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
    scale.set(0x28, 0x1052, "DS", "-1000").set(0x28, 0x1053, "DS", "2");
    shared.setItems(0x28, 0x9110, {measures})
        .setItems(0x20, 0x9116, {axes})
        .setItems(0x28, 0x9145, {scale});
    std::string pixels;
    for (std::size_t k = 0; k < frames.size(); ++k)
        for (std::size_t i = 0; i < 4; ++i) pixels += dicomShort(100 * k + i);
    return dicomSlice("0", pixels)
        .erase(0x20, 0x32)
        .erase(0x20, 0x37)
        .erase(0x28, 0x30)
        .set(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2.1")
        .set(0x28, 8, "IS", std::to_string(frames.size()))
        .setItems(0x5200, 0x9229, {shared})
        .setItems(0x5200, 0x9230, frames);
}

}  // namespace vdbpack::test
