// Label maps as .nii, .nrrd and .mha. Their headers are short, and libraries that write them do not
// write through a file without a name.
#include "vdbpack/core/error.h"
#include "vdbpack/image/label_map.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

namespace vdbpack {

namespace {

NumberType typeFor(const std::vector<std::int32_t>& labels) {
    std::int32_t least = 0, most = 0;
    for (const std::int32_t l : labels) {
        least = std::min(least, l);
        most = std::max(most, l);
    }
    if (least < 0 || most > std::numeric_limits<std::uint16_t>::max()) return NumberType::i32;
    return most > std::numeric_limits<std::uint8_t>::max() ? NumberType::u16 : NumberType::u8;
}

/// The value for one of the three types.
template <class T>
T of(NumberType type, T u8, T u16, T i32) {
    return type == NumberType::u8 ? u8 : type == NumberType::u16 ? u16 : i32;
}

/// The numbers of labels from `begin` to `end` as bytes, the least first.
void appendBytes(const std::vector<std::int32_t>& labels, std::size_t begin, std::size_t end,
                 NumberType type, std::string& bytes) {
    const std::size_t width = bytesOf(type);
    for (std::size_t i = begin; i < end; ++i) {
        auto value = static_cast<std::uint32_t>(labels[i]);
        for (std::size_t b = 0; b < width; ++b, value >>= 8)
            bytes.push_back(static_cast<char>(value));
    }
}

constexpr std::size_t kPiece = std::size_t{1} << 20;  // labels

/// Windows of zlib: with the header of gzip, or of zlib.
enum class Wrapper { gzip = MAX_WBITS + 16, zlib = MAX_WBITS };

/// Deflates a header and the labels after it, and hands the bytes on.
class Deflater {
public:
    explicit Deflater(Wrapper wrapper) {
        if (deflateInit2(&stream_, Z_BEST_SPEED, Z_DEFLATED, static_cast<int>(wrapper), 8,
                         Z_DEFAULT_STRATEGY) != Z_OK)
            throw ResourceError("a label map cannot be compressed: too little memory");
    }
    ~Deflater() { deflateEnd(&stream_); }
    Deflater(const Deflater&) = delete;
    Deflater& operator=(const Deflater&) = delete;

    template <class Take>
    void add(const std::string& bytes, bool last, const Take& take) {
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
        stream_.avail_in = static_cast<uInt>(bytes.size());
        std::string out(std::size_t{1} << 18, '\0');
        do {
            stream_.next_out = reinterpret_cast<Bytef*>(out.data());
            stream_.avail_out = static_cast<uInt>(out.size());
            deflate(&stream_, last ? Z_FINISH : Z_NO_FLUSH);
            take(out.substr(0, out.size() - stream_.avail_out));
        } while (stream_.avail_out == 0);
    }

private:
    z_stream stream_{};
};

/// Hands on the labels as bytes, deflated or plain.
template <class Take>
void forEachPiece(const LabelMap& map, NumberType type, const std::string& header,
                  const Wrapper* wrapper, const Take& take) {
    std::optional<Deflater> deflater;
    if (wrapper) deflater.emplace(*wrapper);
    std::string bytes = header;
    for (std::size_t i = 0; i < map.labels.size(); i += kPiece) {
        const std::size_t end = std::min(i + kPiece, map.labels.size());
        appendBytes(map.labels, i, end, type, bytes);
        if (deflater)
            deflater->add(bytes, end == map.labels.size(), take);
        else
            take(bytes);
        bytes.clear();
    }
}

/// The header of NIfTI-1 and the four bytes after it.
std::string niftiHeader(const LabelMap& map, NumberType type, const std::string& path,
                        const std::string& note) {
    const ImageGrid& grid = map.grid;
    std::string header(352, '\0');
    const auto set = [&header](std::size_t at, auto value) {
        std::memcpy(header.data() + at, &value, sizeof value);
    };
    set(0, std::int32_t{348});
    set(40, std::int16_t{3});
    for (std::size_t d = 0; d < 7; ++d) {
        const std::size_t size = d < 3 ? grid.size[d] : 1;
        if (size > 32767)
            throw ParameterError(fmt::format(
                "{}: {} voxels along an axis are more than NIfTI has numbers for; write .nrrd",
                path, size));
        set(42 + 2 * d, static_cast<std::int16_t>(size));
    }
    set(70, of<std::int16_t>(type, 2, 512, 8));
    set(72, of<std::int16_t>(type, 8, 16, 32));
    set(76, 1.0f);
    for (std::size_t d = 0; d < 3; ++d) set(80 + 4 * d, static_cast<float>(length(grid.step[d])));
    set(108, 352.0f);
    set(112, 1.0f);             // slope
    set(123, std::uint8_t{2});  // mm
    note.copy(header.data() + 148, 79);
    set(254, std::int16_t{1});  // sform: coordinates of the scanner
    for (std::size_t row = 0; row < 3; ++row) {
        const double sign = row < 2 ? -1 : 1;  // from LPS to RAS
        for (std::size_t axis = 0; axis < 3; ++axis)
            set(280 + 16 * row + 4 * axis, static_cast<float>(sign * grid.step[axis].c[row]));
        set(280 + 16 * row + 12, static_cast<float>(sign * grid.origin.c[row]));
    }
    header.replace(344, 3, "n+1");
    return header;
}

std::string numbers(const Vec<3>& v, const char* format) {
    return fmt::format(fmt::runtime(format), v[0], v[1], v[2]);
}

std::string nrrdHeader(const LabelMap& map, NumberType type, const std::string& note) {
    const ImageGrid& grid = map.grid;
    constexpr const char* kVector = "({:.17g},{:.17g},{:.17g})";
    std::string header = "NRRD0004\n# " + note + "\n";
    header += fmt::format("type: {}\ndimension: 3\n", nameOf(type));
    header += "space: left-posterior-superior\n";
    header += fmt::format("sizes: {} {} {}\n", grid.size[0], grid.size[1], grid.size[2]);
    header += "space directions:";
    for (const Vec<3>& step : grid.step) header += ' ' + numbers(step, kVector);
    header += "\nkinds: domain domain domain\nendian: little\nencoding: gzip\n";
    return header + "space origin: " + numbers(grid.origin, kVector) + "\n\n";
}

std::string metaHeader(const LabelMap& map, NumberType type, std::size_t bytes,
                       const std::string& note) {
    const ImageGrid& grid = map.grid;
    std::string header = "ObjectType = Image\nNDims = 3\nComment = " + note +
                         "\nBinaryData = True\nBinaryDataByteOrderMSB = False\n";
    header +=
        fmt::format("CompressedData = True\nCompressedDataSize = {}\nTransformMatrix =", bytes);
    for (const Vec<3>& step : grid.step)
        header += numbers(normalized(step), " {:.17g} {:.17g} {:.17g}");
    header += "\nOffset =" + numbers(grid.origin, " {:.17g} {:.17g} {:.17g}");
    header += "\nCenterOfRotation = 0 0 0";
    header += "\nElementSpacing =" + numbers(grid.spacing(), " {:.17g} {:.17g} {:.17g}");
    header += fmt::format("\nDimSize = {} {} {}\n", grid.size[0], grid.size[1], grid.size[2]);
    return header + fmt::format("ElementType = {}\nElementDataFile = LOCAL\n",
                                of(type, "MET_UCHAR", "MET_USHORT", "MET_INT"));
}

}  // namespace

bool namesLabelMap(const std::string& path) {
    const std::string extension = extensionOf(path);
    return extension == ".nii" || extension == ".nrrd" || extension == ".mha" ||
           (extension == ".gz" && extensionOf(path.substr(0, path.size() - 3)) == ".nii");
}

void writeLabelMap(const LabelMap& map, const std::string& path, const std::string& note) {
    if (!namesLabelMap(path))
        throw ParameterError(
            path + ": label maps are written as .nii, .nii.gz, .nrrd or .mha; name it so");
    const std::string extension = extensionOf(path), comment = oneLine(note);
    const NumberType type = typeFor(map.labels);
    OutputFile out(path);
    const auto write = [&out](const std::string& bytes) { out.write(bytes); };
    constexpr Wrapper kGzip = Wrapper::gzip, kZlib = Wrapper::zlib;
    if (extension == ".nrrd") {
        out.write(nrrdHeader(map, type, comment));
        forEachPiece(map, type, "", &kGzip, write);
    } else if (extension == ".mha") {
        std::string deflated;  // its size stands before it
        forEachPiece(map, type, "", &kZlib,
                     [&deflated](const std::string& bytes) { deflated += bytes; });
        out.write(metaHeader(map, type, deflated.size(), comment));
        out.write(deflated);
    } else {
        forEachPiece(map, type, niftiHeader(map, type, path, comment),
                     extension == ".gz" ? &kGzip : nullptr, write);
    }
    out.commit();
}

}  // namespace vdbpack
