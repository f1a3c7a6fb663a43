// The points of a .vdb file, as io of OpenVDB's points reads them: see vdb_check.cpp.
#include "vdbpack/field/vdb_bytes.h"

#include <fmt/format.h>
#include <openvdb/points/AttributeArray.h>

#include <limits>
#include <map>
#include <set>
#include <string>

namespace vdbpack {

namespace {

constexpr std::uint32_t kMultiPass = 224;  ///< points are read pass by pass from here on
constexpr std::uint64_t kMostPointsPerByte = 16;

/// Attribute arrays that follow each other in pages.
class Pages {
public:
    /// An array of `count` bytes is announced: in the page before, or in one whose sizes stand
    /// here.
    void announce(VdbBytes& bytes, std::uint64_t count) {
        if (index_ == held_) {
            Page page;
            page.stored = bytes.get<std::int32_t>("the size of a page");
            page.held = page.stored > 0 ? bytes.get<std::int32_t>("the size of a page")
                                        : -static_cast<std::int64_t>(page.stored);
            if (page.held <= 0) bytes.fail(fmt::format("a page of {} bytes", page.held));
            pages_.push_back(page);
            held_ = static_cast<std::uint64_t>(page.held);
            index_ = 0;
        }
        if (count > held_ - index_)
            bytes.fail(fmt::format("an array of {} bytes in a page that has {} left", count,
                                   held_ - index_));
        index_ += count;
        arrays_.push_back({pages_.size() - 1, index_ == count});
    }
    /// All arrays are announced.
    void close(const VdbBytes& bytes) const {
        if (index_ != held_) bytes.fail("a page is larger than its arrays");
    }
    struct Page {
        std::int64_t stored = 0;  ///< bytes in the file, negative if they are plain
        std::int64_t held = 0;    ///< bytes once unpacked
    };
    /// The page that begins with the array announced as number `array`, or none.
    const Page* pageAt(std::size_t array) const {
        return arrays_[array].begins ? &pages_[arrays_[array].page] : nullptr;
    }

private:
    struct Announced {
        std::size_t page;
        bool begins;
    };
    std::vector<Page> pages_;
    std::vector<Announced> arrays_;
    std::uint64_t held_ = 0, index_ = 0;
};

/// An array of one leaf, as its metadata describes it.
struct AttributeArray {
    std::uint64_t bytes = 0;
    bool uniform = false;
    bool paged = false;
    std::size_t announced = 0;  ///< place among those of its attribute
};

class PointCheck {
public:
    explicit PointCheck(VdbBytes& bytes) : bytes_(bytes) {}

    void run(std::uint32_t version, const std::vector<LeafMask>& leaves) {
        if (version < kMultiPass)
            throw InputError(
                fmt::format("{}: holds points in format version {}; save it by a program with "
                            "OpenVDB 5 or later",
                            bytes_.path(), version));
        const auto passes = bytes_.get<std::uint16_t>("the points");
        if (leaves.empty()) return;  // and passes may be none
        if (passes < 4 || passes % 2 != 0) bytes_.fail(fmt::format("points in {} passes", passes));
        const std::size_t attributes = (passes - 4u) / 2;

        bytes_.skip(2 * leaves.size(), "the sizes of voxels");
        std::vector<std::size_t> elementBytes;
        std::vector<std::vector<AttributeArray>> arrays;  // by leaf
        bool shared = false;                              // all leaves have the same attributes
        for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
            if (!shared) shared = checkDescriptor(attributes, elementBytes);
            arrays.emplace_back();
            std::uint64_t points = 0;
            for (std::size_t a = 0; a < attributes; ++a)
                arrays.back().push_back(checkArray(elementBytes[a], points));
        }
        if (points_ > kMostPointsPerByte * bytes_.size())
            bytes_.fail(fmt::format("{} points in a file of {} bytes", points_, bytes_.size()));

        std::vector<Pages> pages(attributes);
        for (std::size_t a = 0; a < attributes; ++a) {
            std::size_t announced = 0;
            for (auto& leaf : arrays) {
                if (!leaf[a].paged) continue;
                leaf[a].announced = announced++;
                pages[a].announce(bytes_, leaf[a].bytes);
            }
            pages[a].close(bytes_);
        }
        for (const LeafMask& mask : leaves) {
            bytes_.skipLeafMask(mask);
            constexpr std::uint64_t kVoxels = 512 * 4;
            const auto stored = bytes_.get<std::uint16_t>("the voxels of a leaf");
            if (stored == std::numeric_limits<std::uint16_t>::max())
                bytes_.skip(kVoxels, "the voxels of a leaf");
            else
                bytes_.skipBlosc(stored, kVoxels, /*padded=*/false);
        }
        for (std::size_t a = 0; a < attributes; ++a)
            for (const auto& leaf : arrays) checkArrayValues(leaf[a], pages[a]);
    }

private:
    /// The names and types of the attributes. @return whether they hold for all further leaves
    bool checkDescriptor(std::size_t attributes, std::vector<std::size_t>& elementBytes) {
        const auto flags = bytes_.get<std::uint8_t>("the attributes of points");
        if (flags > 3) bytes_.fail(fmt::format("attributes with flags {}", flags));
        const auto count = bytes_.get<std::uint64_t>("the attributes of points");
        if (count != attributes)
            bytes_.fail(
                fmt::format("{} attributes of points where {} are announced", count, attributes));
        elementBytes.clear();
        for (std::size_t a = 0; a < attributes; ++a) {
            const std::string value = bytes_.text("the type of an attribute");
            const std::string codec = bytes_.text("the type of an attribute");
            elementBytes.push_back(elementBytesOf({value, codec}));
        }
        std::set<std::string> names;
        std::set<std::uint64_t> places;
        for (std::size_t a = 0; a < attributes; ++a) {
            const bool isNew = names.insert(bytes_.text("the name of an attribute")).second;
            const auto place = bytes_.get<std::uint64_t>("the position of an attribute");
            if (!isNew || place >= attributes || !places.insert(place).second)
                bytes_.fail(
                    fmt::format("an attribute twice, or at position {} of {}", place, attributes));
        }
        const auto groups = bytes_.get<std::uint64_t>("the groups of points");
        if (groups > bytes_.left() / 12) bytes_.fail(fmt::format("{} groups of points", groups));
        for (std::uint64_t g = 0; g < groups; ++g) {
            bytes_.text("the name of a group");
            bytes_.skip(8, "the offset of a group");
        }
        checkMetadata(bytes_);
        if ((flags & 2) != 0) {
            const auto more = bytes_.get<std::uint64_t>("the attributes of points");
            bytes_.skip(more, "the attributes of points");
        }
        return (flags & 1) != 0;
    }

    std::size_t elementBytesOf(const openvdb::NamePair& type) {
        const auto known = elementBytesOfType_.find(type);
        if (known != elementBytesOfType_.end()) return known->second;
        using openvdb::points::AttributeArray;
        if (!AttributeArray::isRegistered(type))
            bytes_.fail(fmt::format("an attribute of type '{}' as '{}'", type.first.substr(0, 40),
                                    type.second.substr(0, 40)));
        const std::size_t size = AttributeArray::create(type, 1, 1)->storageTypeSize();
        return elementBytesOfType_[type] = size;
    }

    /// @param points  of the leaf: set by its first array, and the same for the others.
    AttributeArray checkArray(std::size_t elementBytes, std::uint64_t& points) {
        constexpr std::uint64_t kPrefix = 6;
        constexpr unsigned kConstantStride = 8, kUnknown = 0x20;
        constexpr unsigned kStrided = 1, kUniform = 2, kPaged = 8, kUnknownLayout = 0x10;
        AttributeArray array;
        const auto announced = bytes_.get<std::uint64_t>("an array");
        const unsigned flags = bytes_.get<std::uint8_t>("an array");
        const unsigned layout = bytes_.get<std::uint8_t>("an array");
        const std::uint64_t size = bytes_.get<std::uint32_t>("an array");
        const std::uint64_t stride =
            (layout & kStrided) != 0 ? bytes_.get<std::uint32_t>("an array") : 1;
        if (announced < kPrefix || flags >= kUnknown || (flags & kConstantStride) == 0 ||
            layout >= kUnknownLayout || size == 0 || stride == 0)
            bytes_.fail(fmt::format("an array of {} points, {} values each, flags {:#x} and {:#x}",
                                    size, stride, flags, layout));
        if (points == 0) points_ += size;
        if (points != 0 && points != size)
            bytes_.fail(fmt::format("arrays of {} and {} points in one leaf", points, size));
        points = size;
        array.bytes = announced - kPrefix;
        array.uniform = (layout & kUniform) != 0;
        array.paged = (layout & kPaged) != 0;
        const std::uint64_t plain = array.uniform ? elementBytes : elementBytes * size * stride;
        // No product overflows: size has 32 bits, and no element more than 128 bytes.
        if (stride > (std::uint64_t{1} << 16) || array.bytes != plain ||
            array.bytes > std::numeric_limits<std::int32_t>::max())
            bytes_.fail(fmt::format("an array of {} bytes where {} points need {}", array.bytes,
                                    size, plain));
        return array;
    }

    void checkArrayValues(const AttributeArray& array, const Pages& pages) {
        if (!array.paged) {
            // Arrays in leaves are packed by the page, or not at all.
            if (!array.uniform && bytes_.get<std::uint8_t>("an array") == 1)
                bytes_.fail("an array packed on its own");
            bytes_.skip(array.bytes, "an array");
            return;
        }
        const auto* page = pages.pageAt(array.announced);
        if (page == nullptr) return;
        if (page->stored < 0)
            bytes_.skip(static_cast<std::uint64_t>(page->held), "a page of points");
        else
            bytes_.skipBlosc(static_cast<std::uint64_t>(page->stored),
                             static_cast<std::uint64_t>(page->held), /*padded=*/true);
    }

    VdbBytes& bytes_;
    std::uint64_t points_ = 0;
    std::map<openvdb::NamePair, std::size_t> elementBytesOfType_;
};

}  // namespace

void checkPoints(VdbBytes& bytes, std::uint32_t version, const std::vector<LeafMask>& leaves) {
    PointCheck(bytes).run(version, leaves);
}

}  // namespace vdbpack
