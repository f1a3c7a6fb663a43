#include "vdbpack/image/dicom_check.h"

#include "vdbpack/image/dicom_pixels.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

// Source: DICOM PS3.5 (encoding), PS3.10 (files), PS3.6 (elements).
constexpr std::uint32_t kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd;
constexpr std::uint32_t kSyntax = 0x00020010, kPixels = 0x7fe00010, kUnknown = 0xffffffff;
constexpr std::uint32_t kRows = 0x00280010, kColumns = 0x00280011, kFrames = 0x00280008,
                        kSamples = 0x00280002, kAllocated = 0x00280100, kStored = 0x00280101,
                        kHigh = 0x00280102, kSign = 0x00280103;
constexpr int kDeepest = 16;

constexpr std::string_view kShort =
    "AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US ";
constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV ";

/// An element that GDCM takes values from.
struct Rule {
    std::uint32_t tag;
    const char* vr;
    int numbers;  ///< how many; 0: any
};
constexpr Rule kRules[] = {
    {0x00020000, "UL", 0}, {0x00020001, "OB", 0}, {0x00020002, "UI", 0}, {0x00020003, "UI", 0},
    {kSyntax, "UI", 0},    {0x00080008, "CS", 0}, {0x00080016, "UI", 0}, {0x00080018, "UI", 0},
    {0x00080060, "CS", 0}, {0x00180050, "DS", 1}, {0x00180088, "DS", 1}, {0x00181114, "DS", 1},
    {0x00181164, "DS", 2}, {0x00182010, "DS", 2}, {0x0020000d, "UI", 0}, {0x0020000e, "UI", 0},
    {0x00200011, "IS", 0}, {0x00200013, "IS", 0}, {0x00200032, "DS", 3}, {0x00200037, "DS", 6},
    {kSamples, "US", 1},   {0x00280004, "CS", 0}, {0x00280006, "US", 1}, {kFrames, "IS", 1},
    {kRows, "US", 1},      {kColumns, "US", 1},   {0x00280030, "DS", 2}, {0x00280034, "IS", 2},
    {kAllocated, "US", 1}, {kStored, "US", 1},    {kHigh, "US", 1},      {kSign, "US", 1},
    {0x00281050, "DS", 0}, {0x00281051, "DS", 0}, {0x00281052, "DS", 1}, {0x00281053, "DS", 1},
    {0x00281054, "LO", 0}, {0x00282110, "CS", 0}, {0x00880200, "SQ", 0}, {0x52009229, "SQ", 0},
    {0x52009230, "SQ", 0}, {0x60000010, "US", 1}, {0x60000011, "US", 1}, {0x60000015, "IS", 1},
    {0x60000022, "LO", 0}, {0x60000040, "CS", 0}, {0x60000050, "SS", 2}, {0x60000100, "US", 1},
    {0x60000102, "US", 1}, {0x60001500, "LO", 0},
};

/// Encodings of pixels that GDCM decodes; the first two are none.
constexpr std::string_view kSyntaxes[] = {
    "1.2.840.10008.1.2",      "1.2.840.10008.1.2.1",    "1.2.840.10008.1.2.4.50",
    "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70",
    "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81", "1.2.840.10008.1.2.4.90",
    "1.2.840.10008.1.2.4.91", "1.2.840.10008.1.2.5"};

struct Element {
    std::uint32_t tag = 0, length = 0;
    std::string vr;           // empty: the file does not say
    std::uint64_t value = 0;  // where it begins
};

std::string nameOf(std::uint32_t tag) {
    return fmt::format("({:04x},{:04x})", tag >> 16, tag & 0xffff);
}

std::uint32_t number(const unsigned char* bytes, std::size_t count) {
    return static_cast<std::uint32_t>(unsignedNumber(bytes, count, false));
}

class DicomWalk {
public:
    explicit DicomWalk(const std::string& path) : file_(path) {}

    DicomKind kind() {
        DicomKind kind;
        char mark[4] = {};
        if (file_.size() >= 132) file_.readAt(128, mark, 4);
        kind.dicom = std::string_view(mark, 4) == "DICM";
        if (!kind.dicom) return kind;
        const std::uint64_t begin = walkMeta();
        walkElements(begin, file_.size(), false, implicit_, 0);
        if (values_[0x00080016] == "1.2.840.10008.5.1.4.1.1.66.5")
            file_.fail(
                "is a DICOM surface segmentation, which is not read; convert it to .stl or .ply "
                "with 3D Slicer");
        kind.image = pixels_.tag == kPixels || values_.count(kRows) > 0;
        if (kind.image) checkPixels();
        kind.pixels = packed_ ? 0 : pixels_.value;
        for (const std::uint32_t tag :
             {0x0020000eU, 0x00200011U, 0x00180024U, 0x00180050U, kRows, kColumns})
            kind.series += values_[tag] + '\n';
        return kind;
    }

private:
    /// The elements about the file itself. @return where the others begin
    std::uint64_t walkMeta() {
        std::uint64_t at = 132;
        while (at + 8 <= file_.size()) {
            if (file_.numberAt(at, 2, false) != 2) break;
            const Element e = elementAt(at, file_.size(), false);
            if (e.length == kUnknown) fail(at, e.tag, "has no length");
            check(e, at, 0);
            at = e.value + e.length;
        }
        const auto known = std::find(std::begin(kSyntaxes), std::end(kSyntaxes), values_[kSyntax]);
        if (known == std::end(kSyntaxes))
            file_.fail("its encoding is " + quotedExcerpt(values_[kSyntax]) +
                       ", which is not read; convert it to explicit little endian (1.2.840.10008."
                       "1.2.1)");
        implicit_ = known == std::begin(kSyntaxes);
        packed_ = known - std::begin(kSyntaxes) > 1;
        return at;
    }

    Element elementAt(std::uint64_t at, std::uint64_t end, bool implicit) {
        unsigned char bytes[12] = {};
        const auto need = [&](std::uint64_t count) {
            if (end - at < count) file_.failAtByte(at, "ends within an element; it is damaged");
            file_.readAt(at, bytes, count);
        };
        need(8);
        Element e;
        e.tag = number(bytes, 2) << 16 | number(bytes + 2, 2);
        e.value = at + 8;
        e.length = number(bytes + 4, 4);
        if (!implicit && e.tag >> 16 != 0xfffe) {
            e.vr.assign(reinterpret_cast<char*>(bytes) + 4, 2);
            e.length = number(bytes + 6, 2);
            if (kLong.find(e.vr + ' ') != std::string_view::npos) {
                need(12);
                e.value = at + 12;
                e.length = number(bytes + 8, 4);
            } else if (kShort.find(e.vr + ' ') == std::string_view::npos) {
                fail(at, e.tag, "is of no known representation: " + quotedExcerpt(e.vr));
            }
        }
        if (e.length != kUnknown && e.length > end - e.value)
            fail(at, e.tag,
                 fmt::format("has {} bytes, but only {} follow", e.length, end - e.value));
        return e;
    }

    /// @param delimited  whether an element ends them, rather than `end`
    std::uint64_t walkElements(std::uint64_t at, std::uint64_t end, bool delimited, bool implicit,
                               int depth) {
        while (at < end) {
            const Element e = elementAt(at, end, implicit);
            if (delimited && e.tag == kItemEnd && e.length == 0) return e.value;
            if (e.tag >> 16 == 0xfffe || e.tag >> 16 < 4) fail(at, e.tag, "is out of place");
            check(e, at, depth);
            at = walkValue(e, at, end, implicit, depth);
        }
        if (delimited) file_.failAtByte(at, std::string("an item has no end") + kDamaged);
        return at;
    }

    /// @return where the next element begins
    std::uint64_t walkValue(const Element& e, std::uint64_t at, std::uint64_t end, bool implicit,
                            int depth) {
        if (e.tag == kPixels && e.length == kUnknown) {
            if (!packed_ || depth > 0) fail(at, e.tag, "has no length");
            return walkItems(e.value, end, false, true, depth);
        }
        if (e.length != kUnknown && e.vr != "SQ") return e.value + e.length;
        if (!implicit && e.vr != "SQ" && e.vr != "UN") fail(at, e.tag, "has no length");
        if (depth == kDeepest) fail(at, e.tag, "lies in too many others");
        // Elements in one of an unknown kind are implicit (PS3.5, 6.2.2).
        const bool within = implicit || e.vr == "UN";
        if (e.length == kUnknown) return walkItems(e.value, end, within, false, depth + 1);
        walkItems(e.value, e.value + e.length, within, false, depth + 1, true);
        return e.value + e.length;
    }

    /// Items of a sequence, or fragments of pixels.
    std::uint64_t walkItems(std::uint64_t at, std::uint64_t end, bool implicit, bool fragments,
                            int depth, bool bounded = false) {
        while (at < end) {
            const Element e = elementAt(at, end, implicit);
            if (!bounded && e.tag == kSequenceEnd && e.length == 0) return e.value;
            if (e.tag != kItem) fail(at, e.tag, "stands where an item begins");
            if (fragments && e.length == kUnknown) fail(at, e.tag, "has no length");
            if (fragments) fragments_.push_back({e.value, e.value + e.length});
            if (fragments || e.length == 0)
                at = e.value + e.length;
            else if (e.length == kUnknown)
                at = walkElements(e.value, end, true, implicit, depth);
            else
                at = walkElements(e.value, e.value + e.length, false, implicit, depth);
        }
        if (!bounded) file_.failAtByte(at, std::string("a sequence has no end") + kDamaged);
        return at;
    }

    void check(const Element& e, std::uint64_t at, int depth) {
        const std::uint32_t tag = e.tag >> 24 == 0x60 ? e.tag & 0xff00ffff : e.tag;
        const auto rule = std::find_if(std::begin(kRules), std::end(kRules),
                                       [&](const Rule& r) { return r.tag == tag; });
        const bool known = rule != std::end(kRules);
        if (known && !e.vr.empty() && e.vr != rule->vr)
            fail(at, e.tag, fmt::format("is of representation {}, not {}", e.vr, rule->vr));
        if (e.tag == kPixels) {
            if (!e.vr.empty() && e.vr != "OB" && e.vr != "OW")
                fail(at, e.tag, fmt::format("is of representation {}, not OB or OW", e.vr));
            if (depth == 0) pixels_ = e;
        }
        const bool text = known ? std::string_view(rule->vr) != "SQ" : e.tag == 0x00180024;
        if (!text || e.length > 1024) return;
        std::string value(e.length, ' ');
        file_.readAt(e.value, value.data(), value.size());
        if (known && rule->numbers > 0 && e.length > 0) value = numbers(*rule, value, at);
        while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
        if (depth == 0 && !values_.emplace(e.tag, value).second) fail(at, e.tag, "occurs twice");
    }

    /// Numbers as text. @throws InputError where there are fewer or more
    std::string numbers(const Rule& rule, const std::string& value, std::uint64_t at) const {
        const std::string_view vr = rule.vr;
        if (vr == "US" || vr == "SS") {
            if (value.size() != static_cast<std::size_t>(2 * rule.numbers))
                fail(at, rule.tag, fmt::format("has {} bytes", value.size()));
            return std::to_string(number(reinterpret_cast<const unsigned char*>(value.data()), 2));
        }
        const auto list = splitAt(std::string_view(value).substr(0, value.find('\0')), '\\');
        bool sound = list.size() == static_cast<std::size_t>(rule.numbers);
        for (const std::string& one : list) {
            double parsed = 0;
            sound = sound && parseNumber(one, parsed) && std::isfinite(parsed);
        }
        if (!sound)
            fail(at, rule.tag,
                 fmt::format("has {}, not {} numbers", quotedExcerpt(value), rule.numbers));
        return value;
    }

    /// A value that is one whole number.
    std::uint64_t one(std::uint32_t tag, std::uint64_t otherwise) const {
        const auto at = values_.find(tag);
        return at == values_.end() || at->second.empty()
                   ? otherwise
                   : std::strtoull(at->second.c_str(), nullptr, 10);
    }

    void require(std::uint32_t tag, bool sound) const {
        const auto at = values_.find(tag);
        if (!sound)
            file_.fail(fmt::format("element {} is {}, which no image has; it is damaged",
                                   nameOf(tag), at == values_.end() ? "missing" : at->second));
    }

    void checkPixels() const {
        const std::uint64_t rows = one(kRows, 0), columns = one(kColumns, 0),
                            samples = one(kSamples, 1), frames = one(kFrames, 1),
                            allocated = one(kAllocated, 0), stored = one(kStored, allocated);
        require(kRows, rows > 0);
        require(kColumns, columns > 0);
        require(kSamples, samples == 1 || samples == 3);
        require(kFrames, frames > 0 && frames < 65536);
        const bool ofBits = allocated == 1 && isDicomSegmentation(values_.at(0x00080016));
        require(kAllocated, allocated == 8 || allocated == 16 || allocated == 32 || ofBits);
        require(kStored, stored > 0 && stored <= allocated);
        require(kHigh, one(kHigh, stored - 1) + 1 == stored);
        require(kSign, one(kSign, 0) <= 1);
        const std::uint64_t bytes = (rows * columns * samples * frames * allocated + 7) / 8;
        if (pixels_.tag != kPixels || (!packed_ && pixels_.length < bytes))
            file_.fail(std::string("ends before its last pixel") + kDamaged);
        if (packed_ != (pixels_.length == kUnknown))
            file_.fail("its pixels are not encoded as it says; it is damaged");
        if (packed_ && ofBits)
            file_.fail(
                "its pixels of one bit are encoded; convert it to explicit little endian (1.2.840."
                "10008.1.2.1)");
        if (packed_)
            checkPackedPixels(file_, values_.at(kSyntax), fragments_,
                              {rows, columns, samples, allocated});
    }

    [[noreturn]] void fail(std::uint64_t at, std::uint32_t tag, const std::string& what) const {
        file_.failAtByte(at, fmt::format("element {} {}; it is damaged", nameOf(tag), what));
    }

    InputFile file_;
    std::map<std::uint32_t, std::string> values_;  // those of the whole file
    Element pixels_;
    std::vector<DicomFragment> fragments_;
    bool implicit_ = false, packed_ = false;
};

}  // namespace

bool isDicomSegmentation(const std::string& sopClass) {
    return sopClass == "1.2.840.10008.5.1.4.1.1.66.4" || sopClass == "1.2.840.10008.5.1.4.1.1.66.7";
}

DicomKind checkDicom(const std::string& path) {
    return DicomWalk(path).kind();
}

}  // namespace vdbpack
