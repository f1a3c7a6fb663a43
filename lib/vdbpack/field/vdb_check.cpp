#include "vdbpack/field/vdb_check.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/vdb_bytes.h"
#include "vdbpack/field/vdb_init.h"

#include <fmt/format.h>
#include <openvdb/Metadata.h>
#include <openvdb/io/Compression.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

// The format has no specification but OpenVDB's own reader, which this follows: io/Archive,
// io/Compression, tree/*Node.h, points/AttributeSet, points/StreamCompression and
// points/PointDataGrid.h of OpenVDB 10.

namespace vdbpack {

namespace {

// 225 (OpenVDB 13) has the layout of 224 and grids of half floats besides.
constexpr std::uint32_t kOldest = 222, kNewest = 225;
constexpr std::uint32_t kZip = 1, kActiveMask = 2, kBlosc = 4;  ///< flags of compression
constexpr std::int32_t kFarthestVoxel = 1 << 30;  ///< voxel; indices stay inside 32 bits

/// What a tree keeps in each voxel.
struct ValueType {
    const char* tree;
    std::size_t bytes;
    std::size_t halfBytes;  ///< where floats are saved as 16 bits; else 0
    bool points = false;
};
constexpr ValueType kValueTypes[] = {
    {"Tree_float_5_4_3", 4, 2},  {"Tree_double_5_4_3", 8, 2},
    {"Tree_vec3s_5_4_3", 12, 6}, {"Tree_vec3d_5_4_3", 24, 6},
    {"Tree_int32_5_4_3", 4, 0},  {"Tree_int64_5_4_3", 8, 0},
    {"Tree_vec3i_5_4_3", 12, 0}, {"Tree_ptdataidx32_5_4_3", 4, 0, true}};

class Walk {
public:
    explicit Walk(const std::string& path) : bytes_(path) {}

    void run() {
        char magic[8] = {};
        if (bytes_.size() >= sizeof magic)
            std::memcpy(magic, bytes_.take(sizeof magic, "the header"), sizeof magic);
        if (std::memcmp(magic, " BDV\0\0\0\0", sizeof magic) != 0)
            throw InputError(bytes_.path() +
                             ": is not an OpenVDB file; check the name of the format");
        version_ = bytes_.get<std::uint32_t>("the version");
        if (version_ < kOldest) failVersion();
        try {
            checkGrids();
        } catch (const InputError&) {
            if (version_ > kNewest) failVersion();
            throw;
        }
    }

private:
    /// A newer version whose layout is the one known passes.
    [[noreturn]] void failVersion() const {
        throw InputError(
            fmt::format("{}: is an OpenVDB file of format version {}, where {} to {} are read; "
                        "save it by a program with OpenVDB 5 to 13",
                        bytes_.path(), version_, kOldest, kNewest));
    }

    void checkGrids() {
        bytes_.skip(8, "the version");
        const bool hasOffsets = bytes_.get<std::uint8_t>("the header") != 0;
        bytes_.skip(36, "the identifier");
        checkMetadata(bytes_);
        const auto count = bytes_.get<std::int32_t>("the number of grids");
        // Three names and three offsets for each.
        if (count < 0 || static_cast<std::uint64_t>(count) > bytes_.left() / 36)
            bytes_.fail(fmt::format("{} grids", count));
        for (std::int32_t i = 0; i < count; ++i) checkGrid(hasOffsets);
    }

    void checkGrid(bool hasOffsets) {
        bytes_.text("the name of a grid");
        std::string type = bytes_.text("the type of a grid");
        constexpr std::string_view kHalf = "_HalfFloat";
        const bool half = type.size() > kHalf.size() &&
                          type.compare(type.size() - kHalf.size(), kHalf.size(), kHalf) == 0;
        if (half) type.resize(type.size() - kHalf.size());
        const bool isInstance = !bytes_.text("the parent of a grid").empty();
        const auto begin = bytes_.get<std::int64_t>("the offset of a grid");
        bytes_.skip(8, "the offset of a grid");  // its values: those of an instance have none
        const auto end = bytes_.get<std::int64_t>("the offset of a grid");
        const auto here = static_cast<std::int64_t>(bytes_.at());
        if (hasOffsets &&
            (begin != here || end < begin || static_cast<std::uint64_t>(end) > bytes_.size()))
            bytes_.fail(fmt::format("a grid from byte {} to byte {}", begin, end));

        compression_ = bytes_.get<std::uint32_t>("the compression of a grid");
        // OpenVDB goes by the metadata, and where they do not say it, values are not.
        bool savedAsHalf = false;
        checkMetadata(bytes_, &savedAsHalf);
        if (savedAsHalf != half)
            bytes_.fail(
                "a grid whose type and metadata disagree on whether its values are half floats");
        checkMap(/*nested=*/false);
        const auto known = std::find_if(std::begin(kValueTypes), std::end(kValueTypes),
                                        [&type](const ValueType& t) { return type == t.tree; });
        if (!isInstance && known != std::end(kValueTypes)) {
            value_ = *known;
            half_ = half && value_.halfBytes > 0;
            checkTree();
        } else if (!isInstance && !hasOffsets) {
            throw InputError(
                fmt::format("{}: was written as a stream and holds a grid of type {}, which cannot "
                            "be skipped; leave that grid out",
                            bytes_.path(), type.substr(0, 80)));
        }
        if (!hasOffsets) return;
        if (bytes_.at() > static_cast<std::uint64_t>(end))
            bytes_.fail(fmt::format("a grid should end at byte {} but continues", end));
        bytes_.seek(static_cast<std::uint64_t>(end));
    }

    // ---- transforms ----------------------------------------------------------------------------

    void checkMap(bool nested) {
        static const std::map<std::string_view, int> kNumbers = {
            {"UniformScaleMap", 15},   {"ScaleMap", 15},          {"UniformScaleTranslateMap", 18},
            {"ScaleTranslateMap", 18}, {"TranslationMap", 3},     {"AffineMap", 16},
            {"UnitaryMap", 16},        {"NonlinearFrustumMap", 8}};
        const std::string type = bytes_.text("the type of a transform");
        const auto known = kNumbers.find(type);
        // A frustum holds another map: one of its kind would nest without end.
        const bool frustum = type == "NonlinearFrustumMap";
        if (known == kNumbers.end() || (nested && frustum))
            bytes_.fail(fmt::format("a transform of type '{}'", type.substr(0, 40)));
        for (int i = 0; i < known->second; ++i)
            if (!std::isfinite(bytes_.get<double>("a transform")))
                bytes_.fail("a transform that is not finite");
        if (frustum) checkMap(/*nested=*/true);
    }

    // ---- trees ---------------------------------------------------------------------------------

    void checkTree() {
        if (bytes_.get<std::int32_t>("a tree") != 1) bytes_.fail("a tree with several buffers");
        bytes_.skip(value_.bytes, "the background of a tree");
        const auto tiles = bytes_.get<std::uint32_t>("the tiles of a tree");
        const auto children = bytes_.get<std::uint32_t>("the nodes of a tree");
        if (tiles > bytes_.left() / (13 + value_.bytes))
            bytes_.fail(fmt::format("{} tiles of a tree", tiles));
        // Nodes have two masks of 4 KB.
        if (children > bytes_.left() / 8192)
            bytes_.fail(fmt::format("{} nodes of a tree", children));
        std::set<std::array<std::int32_t, 3>> origins;
        for (std::uint32_t i = 0; i < tiles; ++i) {
            checkOrigin(origins);
            bytes_.skip(value_.bytes, "a tile");
            if (bytes_.get<std::uint8_t>("a tile") > 1) bytes_.fail("a tile neither on nor off");
        }
        leaves_.clear();
        std::array<std::int32_t, 3> before{};
        for (std::uint32_t i = 0; i < children; ++i) {
            // Values come in the order of the nodes' places.
            const auto origin = checkOrigin(origins);
            if (i > 0 && !(before < origin)) bytes_.fail("nodes of a tree out of order");
            before = origin;
            checkInternal<5>();
        }
        if (value_.points)
            checkPoints(bytes_, version_, leaves_);
        else
            for (const LeafMask& mask : leaves_) {
                bytes_.skipLeafMask(mask);
                checkValues(512, mask, /*unpack=*/false);
            }
    }

    std::array<std::int32_t, 3> checkOrigin(std::set<std::array<std::int32_t, 3>>& origins) {
        constexpr std::int32_t kSide = 1 << 12;
        std::array<std::int32_t, 3> origin{};
        for (auto& x : origin) {
            x = bytes_.get<std::int32_t>("the origin of a node");
            if (x % kSide != 0 || x > kFarthestVoxel || x < -kFarthestVoxel)
                bytes_.fail(fmt::format("a node at voxel {}", x));
        }
        if (!origins.insert(origin).second)
            bytes_.fail(fmt::format("a second node at voxel ({}, {}, {})", origin[0], origin[1],
                                    origin[2]));
        return origin;
    }

    template <int Log2>
    void checkInternal() {
        constexpr std::size_t kValues = std::size_t{1} << (3 * Log2);
        const auto children = bytes_.mask<kValues>();
        const auto active = bytes_.mask<kValues>();
        if ((children & active).any()) bytes_.fail("a node and a value in one position");
        checkValues(kValues, active, /*unpack=*/true);
        for (std::size_t i = 0; i < kValues; ++i) {
            if (!children[i]) continue;
            if constexpr (Log2 == 5)
                checkInternal<4>();
            else
                leaves_.push_back(bytes_.mask<512>());
        }
    }

    /// Values of a node: inactive ones are left out where two stand for all of them.
    /// @param unpack  tries to unpack them: OpenVDB loses the memory of internal nodes if that
    ///                fails.
    template <std::size_t Bits>
    void checkValues(std::size_t count, const std::bitset<Bits>& active, bool unpack) {
        enum { oneInactive = 2, maskOnly = 3, maskOneInactive = 4, maskTwoInactive = 5, all = 6 };
        const auto kind = bytes_.get<std::int8_t>("the values of a node");
        if (kind < 0 || kind > all) bytes_.fail(fmt::format("values of kind {}", kind));
        if (kind == oneInactive || kind == maskOneInactive)
            bytes_.skip(value_.bytes, "an inactive value");
        if (kind == maskTwoInactive) bytes_.skip(2 * value_.bytes, "inactive values");
        if (kind == maskOnly || kind == maskOneInactive || kind == maskTwoInactive)
            bytes_.skip(Bits / 8, "a mask of inactive values");
        if ((compression_ & kActiveMask) != 0 && kind != all) count = active.count();
        if (half_ && count == 0) return;
        checkPacked(count * (half_ ? value_.halfBytes : value_.bytes), unpack);
    }

    /// `expected` bytes, packed or not.
    void checkPacked(std::uint64_t expected, bool unpack) {
        if ((compression_ & (kBlosc | kZip)) == 0) {
            bytes_.skip(expected, "values");
            return;
        }
        const std::uint64_t begin = bytes_.at();
        const auto stored = bytes_.get<std::int64_t>("the size of values");
        if (stored <= 0) {
            // Written this way no size overflows.
            if (stored != -static_cast<std::int64_t>(expected))
                bytes_.fail(
                    fmt::format("{} bytes of values where {} are needed", stored, expected));
            bytes_.skip(expected, "values");
            return;
        }
        if (static_cast<std::uint64_t>(stored) > bytes_.left())
            bytes_.fail(fmt::format("{} bytes of packed values", stored));
        if ((compression_ & kBlosc) != 0)
            bytes_.skipBlosc(static_cast<std::uint64_t>(stored), expected, /*padded=*/false);
        else if (static_cast<std::uint64_t>(stored) > 2 * expected + 64)
            bytes_.fail(fmt::format("{} bytes packed into {}", expected, stored));
        else
            bytes_.skip(static_cast<std::uint64_t>(stored), "values");
        if (!unpack) return;
        const std::uint64_t end = bytes_.at();
        bytes_.seek(begin);
        const auto length = static_cast<std::size_t>(end - begin);
        std::istringstream packed(std::string(bytes_.take(length, "values"), length));
        unpacked_.resize(static_cast<std::size_t>(expected) + 1);
        try {
            if ((compression_ & kBlosc) != 0)
                openvdb::io::bloscFromStream(packed, unpacked_.data(),
                                             static_cast<std::size_t>(expected));
            else
                openvdb::io::unzipFromStream(packed, unpacked_.data(),
                                             static_cast<std::size_t>(expected));
        } catch (const std::exception& e) {
            if (isShortage(e)) throw;
            bytes_.fail("values that cannot be unpacked");
        }
    }

    VdbBytes bytes_;
    std::uint32_t version_ = 0;
    std::uint32_t compression_ = 0;
    ValueType value_{};
    bool half_ = false;
    std::vector<LeafMask> leaves_;  ///< of the tree, in its order
    std::vector<char> unpacked_;
};

void checkDelayedBlock(VdbBytes& bytes, std::uint64_t count, std::size_t each,
                       std::uint32_t stored) {
    if (stored == 0)
        bytes.skip(count * each, "metadata");
    else
        bytes.skipBlosc(stored, count * each, /*padded=*/true);
}

/// Sizes for reading parts of a tree later, which nobody here wants but OpenVDB unpacks.
void checkDelayedLoad(VdbBytes& bytes, std::uint32_t size) {
    if (size == 0) return;
    const std::uint64_t begin = bytes.at();
    const auto count = bytes.get<std::uint32_t>("the number of leaves");
    constexpr std::size_t kMaskBytes = 1, kSizeBytes = 8;
    checkDelayedBlock(bytes, count, kMaskBytes, bytes.get<std::uint32_t>("a size"));
    const auto second = bytes.get<std::uint32_t>("a size");
    if (second != std::numeric_limits<std::uint32_t>::max())
        checkDelayedBlock(bytes, count, kSizeBytes, second);
    const std::uint64_t taken = bytes.at() - begin;
    if (taken < size) bytes.skip(size - taken, "metadata");
}

}  // namespace

void checkMetadata(VdbBytes& bytes, bool* savedAsHalf) {
    const auto count = bytes.get<std::uint32_t>("metadata");
    if (count > bytes.left() / 12) bytes.fail(fmt::format("{} metadata", count));
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::string name = bytes.text("the name of metadata");
        const std::string type = bytes.text("the type of metadata");
        const auto size = bytes.get<std::uint32_t>("the size of metadata");
        if (size > bytes.left())
            bytes.fail(fmt::format("metadata of type {} and {} bytes", type.substr(0, 40), size));
        if (type == "__delayedload") {
            checkDelayedLoad(bytes, size);
            continue;
        }
        // Values of a fixed size are read as such, whatever size is announced.
        if (type != "string" && openvdb::Metadata::isRegisteredType(type) &&
            openvdb::Metadata::createMetadata(type)->size() != size)
            bytes.fail(fmt::format("metadata of type {} in {} bytes", type.substr(0, 40), size));
        if (savedAsHalf && name == "is_saved_as_half_float") {
            if (type != "bool") bytes.fail("metadata of half floats that is not a bool");
            *savedAsHalf = bytes.get<std::uint8_t>("metadata") != 0;
            continue;
        }
        bytes.skip(size, "metadata");
    }
}

void checkVdbFile(const std::string& path) {
    initializeOpenVdb();
    Walk(path).run();
}

}  // namespace vdbpack
