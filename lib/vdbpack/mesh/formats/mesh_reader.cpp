#include "vdbpack/mesh/formats/mesh_reader.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

namespace vdbpack {

std::string MeshReader::complaint(const Vec<3>& p) const {
    if (!isFinite(p))
        return fmt::format("is not finite: ({}, {}, {}); export the mesh again", p[0], p[1], p[2]);
    return fmt::format("lies more than 1e9 mm from the origin: ({}, {}, {}); check the unit", p[0],
                       p[1], p[2]);
}

double MeshReader::real(std::string_view word, const char* what) const {
    double value = 0;
    if (!parseReal(word, value)) failNumber(word, what);
    return value;
}

std::int64_t MeshReader::integer(std::string_view word, const char* what) const {
    std::int64_t value = 0;
    if (!parseInteger(word, value)) failNumber(word, what);
    return value;
}

Vec<3> MeshReader::point(Words& words) const {
    Vec<3> p;
    for (int d = 0; d < 3; ++d) p[d] = real(words.next(), "a coordinate") + 0.0;  // -0 becomes 0
    checkAtLine(p);
    return p;
}

void MeshReader::checkCount(std::uint64_t count, std::uint64_t least, const char* what) const {
    if (least > 0 && count > (file.size() + 1) / least)
        file.fail(
            fmt::format("{} {} are announced, too many for a file of {} bytes; it is truncated or "
                        "its header is wrong",
                        count, what, file.size()));
}

void MeshReader::failNumber(std::string_view word, const char* what) const {
    if (word.empty())
        file.failAtLine(std::string(what) +
                        " expected, but nothing is left; the file may be truncated");
    file.failAtLine(std::string(what) + " expected, found " + quotedExcerpt(word));
}

void MeshReader::failTotal(const char* what, std::size_t most) const {
    throw ResourceError(
        fmt::format("{}: more than {} {}; simplify the mesh", file.path(), most, what));
}

}  // namespace vdbpack
