#include "vdbpack/formats/pack_parts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_target.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/pack_text_rows.h"
#include "vdbpack/formats/vtkhdf.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/shared_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>

namespace vdbpack {

namespace {

/// How many ranks have spheres, and what of the pack is on those before this one.
struct Shares {
    Shares(Ranks* ranks, std::size_t own) {
        const auto all = gathered(ranks, std::vector<std::uint64_t>{own});
        const auto here = static_cast<std::size_t>(ranks ? ranks->rank() : 0);
        for (std::size_t r = 0; r < all.size(); ++r) {
            const std::uint64_t n = all[r].front();
            if (n == 0) continue;
            firstBefore += r < here ? n : 0;
            piecesBefore += r < here;
            ranksWith.push_back(r);
            counts.push_back(n);
            total += n;
        }
    }
    /// What the first rank with spheres says: the others may not know the columns.
    std::string said(Ranks* ranks, const std::string& text) const {
        const auto all = gathered(ranks, std::vector<char>(text.begin(), text.end()));
        const auto& first = all[ranksWith.empty() ? 0 : ranksWith.front()];
        return {first.begin(), first.end()};
    }

    std::vector<std::size_t> ranksWith;
    std::vector<std::uint64_t> counts;  // of these
    std::size_t piecesBefore = 0;
    std::uint64_t firstBefore = 0;  // spheres before those of this rank
    std::uint64_t total = 0;
};

/// Writes `count` values, made one by one, from an offset on.
template <class T, class Get>
void writeValues(SharedFile& file, std::uint64_t offset, std::size_t count, const Get& get) {
    constexpr std::size_t kAtATime = 1 << 15;
    std::vector<T> part;
    for (std::size_t first = 0; first < count; first += kAtATime) {
        part.clear();
        for (std::size_t i = first; i < std::min(count, first + kAtATime); ++i)
            part.push_back(static_cast<T>(get(i)));
        file.writeAt(offset + first * sizeof(T), part.data(), part.size() * sizeof(T));
    }
}

template <int Dim>
void writeTextRows(const PackShare<Dim>& share, const Shares& shares, const PackTextRows& rows,
                   const std::string& path) {
    constexpr std::size_t kRowsAtATime = 8192;
    const std::string header = shares.said(share.ranks, rows.header);
    SharedFile file(share.ranks, path);
    // Twice the same texts: first for their lengths, then where they go.
    const auto forChunks = [&](const RowSpan& span, const auto& take) {
        std::string text;
        for (std::size_t first = span.begin; first < span.end; first += kRowsAtATime) {
            text.clear();
            for (std::size_t i = first; i < std::min(span.end, first + kRowsAtATime); ++i)
                rows.append(text, i);
            take(text);
        }
    };
    std::vector<std::uint64_t> sizes(share.spans.size());
    parallelFor(std::size_t{0}, sizes.size(), [&](std::size_t s) {
        forChunks(share.spans[s], [&](const std::string& text) { sizes[s] += text.size(); });
    });
    const auto starts = startsOfPieces(*share.ranks, share.spans, sizes, share.pieces);
    if (share.ranks->isFirst()) file.writeAt(0, header.data(), header.size());
    parallelFor(std::size_t{0}, sizes.size(), [&](std::size_t s) {
        std::uint64_t at = header.size() + starts[s];
        forChunks(share.spans[s], [&](const std::string& text) {
            file.writeAt(at, text.data(), text.size());
            at += text.size();
        });
    });
    file.commit();
}

template <int Dim>
AllAtoms atomsOver(Ranks& ranks, const PackView& pack, const Shares& shares) {
    AllAtoms all = allAtoms(pack);
    if (shares.total == 0) return all;
    const bool has = pack.size() > 0;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    all.count = shares.total;
    all.types = static_cast<std::int64_t>(maxOver(&ranks, static_cast<double>(all.types)));
    for (int d = 0; d < 3; ++d) {
        all.box.lo[d] = minOver(&ranks, has ? all.box.lo[d] : kInfinity);
        all.box.hi[d] = maxOver(&ranks, has ? all.box.hi[d] : -kInfinity);
    }
    return all;
}

/// A part of the spheres of a pack with what is known of them.
template <int Dim>
Pack<Dim> slice(const Pack<Dim>& pack, std::size_t first, std::size_t last) {
    Pack<Dim> part;
    part.sliceHeight = pack.sliceHeight;
    part.columns.resize(pack.columns.size());
    for (std::size_t c = 0; c < pack.columns.size(); ++c)
        part.columns[c] = {pack.columns[c].name, {}, {}, pack.columns[c].names};
    const auto from = static_cast<std::ptrdiff_t>(first), to = static_cast<std::ptrdiff_t>(last);
    const auto take = [&](const auto& all, auto& some) {
        if (!all.empty()) some.assign(all.begin() + from, all.begin() + to);
    };
    take(pack.spheres, part.spheres);
    take(pack.id, part.id);
    take(pack.region, part.region);
    take(pack.order, part.order);
    take(pack.depth, part.depth);
    take(pack.contacts, part.contacts);
    for (std::size_t c = 0; c < pack.columns.size(); ++c) {
        take(pack.columns[c].numbers, part.columns[c].numbers);
        take(pack.columns[c].texts, part.columns[c].texts);
    }
    return part;
}

/// Parts of a point grid, each made in memory: with those of `kInPart` spheres that is some 150 MB.
template <int Dim>
std::vector<std::string> writeVdbParts(const PackShare<Dim>& share, const Shares& shares,
                                       const PackWriteOptions& options, const std::string& path) {
    constexpr std::uint64_t kInPart = 1'000'000;
    const auto partsOf = [](std::uint64_t n) { return (n + kInPart - 1) / kInPart; };
    std::size_t part = 0, parts = 0;
    for (std::size_t k = 0; k < shares.counts.size(); ++k) {
        if (k < shares.piecesBefore) part += partsOf(shares.counts[k]);
        parts += partsOf(shares.counts[k]);
    }
    const std::size_t n = share.pack.spheres.size();
    for (std::size_t first = 0; first < n; first += kInPart, ++part) {
        const Pack<Dim> some = slice(share.pack, first, std::min<std::size_t>(n, first + kInPart));
        PackWriteOptions alone = options;
        if (part > 0) alone.levelSets.clear();
        OutputFile out(pieceName(path, part, ".vdb"));
        writeVdb(PackView(some, options.unit), alone, out);
        out.commit();
    }
    std::vector<std::string> files;
    for (std::size_t p = 0; p < parts; ++p) files.push_back(pieceName(path, p, ".vdb"));
    return files;
}

}  // namespace

std::string pieceName(const std::string& file, std::size_t piece, const std::string& extension) {
    const std::string stem = file.substr(0, file.size() - extensionOf(file).size());
    return fmt::format("{}_{:04}{}", stem, piece, extension);
}

void writePvtp(Ranks* ranks, const PackView& pack, const PackWriteOptions& options,
               const std::string& path) {
    const Shares shares(ranks, pack.size());
    const bool isFirst = !ranks || ranks->isFirst();
    if (pack.size() > 0 || (shares.total == 0 && isFirst)) {
        OutputFile piece(pieceName(path, shares.piecesBefore, ".vtp"));
        writeVtp(pack, options, piece);
        piece.commit();
    }
    std::string arrays;
    for (const NumberColumn& column : numberColumns(pack))
        arrays += fmt::format("      <PDataArray type=\"{}\" Name=\"{}\"/>\n",
                              vtkNameOf(column.type), escapedXml(column.name));
    pack.forEachAttribute([](std::string_view, const auto&) {},
                          [&](std::string_view name, const auto&) {
                              arrays += fmt::format("      <PArray type=\"String\" Name=\"{}\"/>\n",
                                                    escapedXml(name));
                          });
    arrays = shares.said(ranks, arrays);
    anyOver(ranks, false);  // all pieces are there
    if (isFirst) {
        std::string text = fmt::format(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PPolyData\" version=\"1.0\" "
            "byte_order=\"{}\" header_type=\"UInt64\">\n  <PPolyData GhostLevel=\"0\">\n"
            "    <PPointData Scalars=\"radius\">\n{}    </PPointData>\n"
            "    <PPoints>\n      <PDataArray type=\"Float64\" Name=\"Points\" "
            "NumberOfComponents=\"3\"/>\n    </PPoints>\n",
            hostIsBigEndian() ? "BigEndian" : "LittleEndian", arrays);
        for (std::size_t p = 0; p < std::max<std::size_t>(shares.counts.size(), 1); ++p)
            text += fmt::format(
                "    <Piece Source=\"{}\"/>\n",
                escapedXml(std::filesystem::path(pieceName(path, p, ".vtp")).filename().string()));
        OutputFile out(path);
        out.write(text + "  </PPolyData>\n</VTKFile>\n");
        out.commit();
    }
    anyOver(ranks, false);
}

void writeVtkHdf(Ranks* ranks, const PackView& pack, const PackWriteOptions& options,
                 const std::string& path) {
    const Shares shares(ranks, pack.size());
    SharedFile file(ranks, path);
    std::vector<std::uint64_t> offsets;
    std::string columns;  // a line each
    for (const NumberColumn& column : numberColumns(pack))
        columns += fmt::format("{} {}\n", static_cast<int>(column.type), column.name);
    columns = shares.said(ranks, columns);
    if (!ranks || ranks->isFirst()) {
        std::vector<NumberColumn> all;
        for (std::size_t at = 0; at < columns.size();) {
            const std::size_t blank = columns.find(' ', at), end = columns.find('\n', blank);
            all.push_back({columns.substr(blank + 1, end - blank - 1),
                           static_cast<NumberType>(std::stoi(columns.substr(at, blank - at)))});
            at = end + 1;
        }
        file.requireRoom(bytesOfVtkHdf(shares.total, all));
        const VtkHdfOffsets made =
            layOutVtkHdf(file.temporaryPath(), shares.counts, all, options.unit, options.generator,
                         partLines(pack.attributes()));
        offsets = {made.points, made.types, made.connectivity, made.offsets};
        offsets.insert(offsets.end(), made.columns.begin(), made.columns.end());
    }
    offsets = gathered(ranks, offsets).front();
    const std::size_t n = pack.size();
    const std::uint64_t first = shares.firstBefore;
    if (n > 0) {
        const auto index = [](std::size_t i) { return i; };
        writeValues<std::array<double, 3>>(file, offsets[0] + 24 * first, n,
                                           [&](std::size_t i) { return pack.position(i); });
        constexpr std::uint8_t kVertex = 1;
        writeValues<std::uint8_t>(file, offsets[1] + first, n, [](std::size_t) { return kVertex; });
        writeValues<std::int64_t>(file, offsets[2] + 8 * first, n, index);
        // Each piece ends with its number of points.
        writeValues<std::int64_t>(file, offsets[3] + 8 * (first + shares.piecesBefore), n + 1,
                                  index);
        writeValues<double>(file, offsets[4] + 8 * first, n,
                            [&](std::size_t i) { return pack.radius(i); });
        writeValues<std::int64_t>(file, offsets[5] + 8 * first, n,
                                  [&](std::size_t i) { return pack.id(i); });
        std::size_t column = 6;
        pack.forEachAttribute(
            [&](std::string_view, const auto& numbers) {
                using T = ValueOf<decltype(numbers)>;
                writeValues<T>(file, offsets[column++] + sizeof(T) * first, n,
                               [&](std::size_t i) { return pack.value(numbers, i); });
            },
            [](std::string_view, const auto&) {});
    }
    file.commit();
}

void checkShareFormat(const std::string& file) {
    switch (targetToWrite(file, 0).format) {
        case PackFormat::csv:
        case PackFormat::yade:
        case PackFormat::lammpsData:
        case PackFormat::pvtp:
        case PackFormat::vtkhdf:
        case PackFormat::vdb:
        case PackFormat::points:
            return;
        default:
            throw ParameterError(
                file +
                ": is not written by several processes; use .csv, yade:FILE, .data, .pvtp, "
                ".vtkhdf, .vdb or points:FILE.vdb, and convert one of those");
    }
}

template <int Dim>
std::vector<std::string> writeShare(const PackShare<Dim>& share, const std::string& file,
                                    const PackWriteOptions& options) {
    checkShareFormat(file);
    checkPack(share.pack);
    const PackTarget target = targetToWrite(file, Dim);
    const PackView view(share.pack, options.unit);
    const Shares shares(share.ranks, view.size());
    PackWriteOptions alone = options;
    switch (target.format) {
        case PackFormat::yade:
            writeTextRows(share, shares, yadeRows(view, options), target.path);
            break;
        case PackFormat::lammpsData: {
            std::vector<std::uint64_t> rows(view.size());
            for (const RowSpan& span : share.spans)
                for (std::size_t i = span.begin; i < span.end; ++i)
                    rows[i] = span.row + (i - span.begin);
            const AllAtoms all = atomsOver<Dim>(*share.ranks, view, shares);
            writeTextRows(share, shares, lammpsRows(view, options, all, rows), target.path);
            break;
        }
        case PackFormat::pvtp: {
            writePvtp(share.ranks, view, options, target.path);
            std::vector<std::string> files{target.path};
            for (std::size_t p = 0; p < shares.counts.size(); ++p)
                files.push_back(pieceName(target.path, p, ".vtp"));
            return files;
        }
        case PackFormat::vtkhdf:
            writeVtkHdf(share.ranks, view, options, target.path);
            break;
        case PackFormat::points:
            alone.levelSets.clear();
            return writeVdbParts(share, shares, alone, target.path);
        case PackFormat::vdb:
            return writeVdbParts(share, shares, alone, target.path);
        default:
            writeTextRows(share, shares, csvRows(view), target.path);
            break;
    }
    return {target.path};
}

template std::vector<std::string> writeShare(const PackShare<2>&, const std::string&,
                                             const PackWriteOptions&);
template std::vector<std::string> writeShare(const PackShare<3>&, const std::string&,
                                             const PackWriteOptions&);

}  // namespace vdbpack
