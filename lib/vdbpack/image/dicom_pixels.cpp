#include "vdbpack/image/dicom_pixels.h"

#include "vdbpack/io/text.h"

namespace vdbpack {

namespace {

constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";
constexpr const char* kJpeg2000 = "1.2.840.10008.1.2.4.9";

/// Reads a fragment.
class FragmentCheck {
public:
    FragmentCheck(const InputFile& file, const DicomFragment& fragment, const DicomFrame& frame)
        : file_(file),
          begin_(fragment.begin),
          size_(fragment.end - fragment.begin),
          frame_(frame) {}

    /// The 64 bytes before runs (PS3.5, G.5): how many segments there are, and where they begin.
    void runs() const {
        require(size_ >= 64, 0);
        const std::uint64_t segments = littleEndian(0);
        require(segments == frame_.samples * frame_.allocated / 8 && segments <= 15, 0);
        std::uint64_t last = 63;
        for (std::uint64_t i = 1; i <= segments; ++i) {
            const std::uint64_t next = littleEndian(4 * i);
            require(next > last && next < size_, 4 * i);
            last = next;
        }
    }

    bool isJpeg() const { return size_ >= 2 && number(0, 2) == 0xffd8; }

    /// The segments of a JPEG or JPEG-LS until its pixels (ISO/IEC 10918-1, B.1).
    void jpeg() const {
        bool framed = false;
        require(isJpeg(), 0);
        for (std::uint64_t at = 2;;) {
            require(size_ - at >= 12, at);
            const std::uint64_t marker = number(at, 2), length = number(at + 2, 2);
            const bool standalone = (marker >= 0xffd0 && marker <= 0xffd9) || marker == 0xffff;
            require(marker >= 0xffc0 && !standalone, at);
            require(length >= 2 && length <= size_ - at - 2, at);
            const bool table = marker == 0xffc4 || marker == 0xffc8 || marker == 0xffcc;
            if ((marker <= 0xffcf && !table) || marker == 0xfff7) {
                require(!framed && length == 8 + 3 * frame_.samples, at);
                require(number(at + 5, 2) == frame_.rows && number(at + 7, 2) == frame_.columns &&
                            number(at + 9, 1) == frame_.samples && fits(number(at + 4, 1)),
                        at);
                framed = true;
            }
            if (marker == 0xffda) break;
            at += 2 + length;
        }
        require(framed, 0);
    }

    bool isJpeg2000() const { return size_ >= 4 && number(0, 4) == 0xff4fff51; }

    /// The size of a JPEG 2000 (ISO/IEC 15444-1, A.5.1).
    void jpeg2000() const {
        require(isJpeg2000() && size_ >= 42 + 3 * frame_.samples, 0);
        require(number(4, 2) == 38 + 3 * frame_.samples && number(40, 2) == frame_.samples, 4);
        require(number(8, 4) == frame_.columns && number(12, 4) == frame_.rows, 8);
        for (const std::uint64_t offset : {16U, 20U, 32U, 36U})
            require(number(offset, 4) == 0, offset);
        const std::uint64_t width = number(24, 4), height = number(28, 4);
        require(width > 0 && height > 0, 24);
        for (std::uint64_t i = 0; i < frame_.samples; ++i) {
            const std::uint64_t at = 42 + 3 * i;
            require(fits((number(at, 1) & 0x7f) + 1) && number(at + 1, 2) == 0x0101, at);
        }
    }

private:
    /// Whether numbers of so many bits take the memory that those of the file take.
    bool fits(std::uint64_t bits) const {
        return bits >= 2 && bits <= frame_.allocated && bits > frame_.allocated / 2;
    }

    /// Numbers of JPEG begin with the largest byte.
    std::uint64_t number(std::uint64_t at, std::size_t count) const {
        return file_.numberAt(begin_ + at, count, true);
    }
    std::uint64_t littleEndian(std::uint64_t at) const {
        return file_.numberAt(begin_ + at, 4, false);
    }

    void require(bool sound, std::uint64_t at) const {
        if (!sound)
            file_.failAtByte(begin_ + at, "encoded pixels are not as the file says; it is damaged");
    }

    const InputFile& file_;
    std::uint64_t begin_, size_;
    DicomFrame frame_;
};

}  // namespace

void checkPackedPixels(const InputFile& file, const std::string& syntax,
                       const std::vector<DicomFragment>& fragments, const DicomFrame& frame) {
    if (fragments.size() < 2) file.fail(std::string("has no pixels") + kDamaged);
    for (std::size_t i = 1; i < fragments.size(); ++i) {
        const FragmentCheck check(file, fragments[i], frame);
        // Others than runs may go on from one fragment to the next.
        if (syntax == kRunLengths) {
            check.runs();
        } else if (startsWith(syntax, kJpeg2000)) {
            if (i == 1 || check.isJpeg2000()) check.jpeg2000();
        } else if (i == 1 || check.isJpeg()) {
            check.jpeg();
        }
    }
}

}  // namespace vdbpack
