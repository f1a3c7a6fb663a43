// numpy's .npz: a zip archive with one .npy array per member.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/npy_array.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/formats/zip_archive.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// Further arrays of more columns are no attributes of spheres.
constexpr std::uint64_t kMostComponents = 100;
/// Bytes before the elements of an array that a pack can use.
constexpr std::uint64_t kLongestHeader = 1 << 17;

/// The name of the array in a member, or an empty text for other members.
std::string arrayName(const std::string& member) {
    constexpr std::string_view kEnding = ".npy";
    if (member.size() <= kEnding.size() ||
        std::string_view(member).substr(member.size() - kEnding.size()) != kEnding)
        return {};
    return member.substr(0, member.size() - kEnding.size());
}

/// Bytes of the names of parts.
constexpr std::uint64_t kLargestNames = 1 << 24;

class NpzFile {
public:
    NpzFile(const std::string& path, const PackReadOptions& options)
        : path_(path), zip_(path), options_(options) {}

    Pack<3> read() {
        describeArrays();
        takeNotes();
        chooseColumns();
        return readRows();
    }

private:
    struct Array : NpyArray {
        ZipArchive::Member member;
    };
    /// A column of the pack and the column of the array that it is read from.
    struct Source {
        std::string name;
        Array* array;
        std::uint64_t column;
    };

    [[noreturn]] void fail(const std::string& what) const { throw InputError(path_ + ": " + what); }

    /// Reads what the arrays are, without their elements.
    void describeArrays() {
        for (std::uint64_t i = 0; i < zip_.members(); ++i) {
            const auto member = zip_.member(i);
            const std::string name = arrayName(member.name);
            if (name.empty()) continue;
            const std::string where = path_ + ": array " + quotedExcerpt(name);
            const std::uint64_t header =
                NpyArray::headerBytes(zip_.beginning(member, NpyArray::kPreamble), where);
            if (header > member.size)
                fail(fmt::format("array {} does not fit into the file; it is damaged or cut short",
                                 quotedExcerpt(name)));
            if (header > kLongestHeader) continue;
            auto array =
                NpyArray::describe(zip_.beginning(member, header), member.size, name, where);
            if (array) arrays_.push_back({*std::move(array), member});
        }
    }

    void load(Array& array) { array.take(zip_.content(array.member)); }

    void takeNotes() {
        for (Array& a : arrays_) {
            const bool isUnit = a.name() == kUnitKey;
            if ((!isUnit && a.name() != kGeneratorKey) || !a.isText() || !a.shape().empty())
                continue;
            if (isUnit && a.member.size > kLongestHeader)
                fail("its unit is no word; use m, cm, mm or um");
            if (a.member.size > kLongestHeader) continue;
            load(a);
            if (isUnit)
                options_.unit = unitNamed(a.text(0), path_);
            else
                origin_ = originIn(a.text(0));
        }
    }

    /// The array of numbers that goes by one of `names`, in lower case and best first.
    Array* named(std::initializer_list<std::string_view> names) {
        for (const std::string_view name : names)
            for (Array& a : arrays_)
                if (!a.isText() && lowered(a.name()) == name) return &a;
        return nullptr;
    }

    void chooseColumns() {
        Array* const positions = named({"positions", "position", "centers", "points", "pos"});
        Array* const radii = named({"radii", "radius", "r", "pscale"});
        Array* const sizes = radii ? radii : named({"diameters", "diameter"});
        Array* const rows = positions ? positions : named({"x"});
        if (!rows || (!sizes && !(options_.radius > 0))) failMissing();
        rows_ = rows->rows();
        const auto isColumn = [this](const NpyArray& a, std::uint64_t columns) {
            return !a.shape().empty() && a.rows() == rows_ && a.columns() == columns;
        };
        if (positions && !isColumn(*positions, 3))
            fail(fmt::format("array '{}' has shape ({}); (N, 3) is needed", positions->name(),
                             fmt::join(positions->shape(), ", ")));
        if (sizes && !isColumn(*sizes, 1))
            fail(fmt::format(
                "array '{}' has shape ({}) beside {} positions; one number each is needed",
                sizes->name(), fmt::join(sizes->shape(), ", "), rows_));
        if (positions)
            for (std::uint64_t d = 0; d < 3; ++d)
                columns_.push_back({std::string(1, "xyz"[d]), positions, d});
        if (sizes) columns_.push_back({radii ? "radius" : "diameter", sizes, 0});
        for (Array& a : arrays_) {
            if (&a == positions || &a == sizes || a.name() == kUnitKey ||
                a.name() == kGeneratorKey || a.name() == kPartNamesKey || a.shape().empty() ||
                a.rows() != rows_)
                continue;
            if (a.columns() > kMostComponents || (a.isText() && a.columns() > 1)) continue;
            std::vector<std::string> names;
            addNames(names, a.name(), a.columns());
            for (std::uint64_t c = 0; c < a.columns(); ++c) columns_.push_back({names[c], &a, c});
        }
    }

    [[noreturn]] void failMissing() const {
        std::string found;
        for (std::size_t i = 0; i < std::min<std::size_t>(arrays_.size(), 20); ++i)
            found += (i > 0 ? ", " : "") + quotedExcerpt(arrays_[i].name());
        fail(
            fmt::format("arrays positions (N, 3), or x, y and z, and radii (N) are needed, found: "
                        "{}; save them by these names",
                        found.empty() ? "none" : found));
    }

    /// Unpacks the chosen arrays: no other ever is.
    void loadColumns(double rowBytes) {
        double bytes = rowBytes;
        std::vector<Array*> chosen;
        for (const Source& s : columns_)
            if (chosen.empty() || chosen.back() != s.array) chosen.push_back(s.array);
        // Texts are unpacked and copied.
        for (const Array* a : chosen)
            bytes += (a->isText() ? 2 : 1) * static_cast<double>(a->member.size);
        requireMemoryToRead(path_, bytes, options_.memoryLimit);
        for (Array* a : chosen) load(*a);
    }

    Pack<3> readRows() {
        std::vector<std::string> names;
        for (const Source& s : columns_) names.push_back(s.name);
        PackBuilder builder(path_, names, options_);
        for (std::size_t c = 0; c < columns_.size(); ++c)
            if (columns_[c].array->isText()) builder.makeText(c);
        loadColumns(builder.bytesOf(rows_));
        builder.reserve(static_cast<std::size_t>(rows_));
        std::vector<PackBuilder::Put> puts;
        for (const Source& from : columns_)
            puts.push_back([&](std::size_t column, std::uint64_t row) {
                if (!from.array->isText())
                    return from.array->number(
                        row, from.column, [&](auto value) { return builder.set(column, value); });
                builder.setText(column, from.array->text(row));
                return true;
            });
        builder.addRows(rows_, puts, "row");
        Pack<3> pack = builder.finish();
        setPartNames(pack, partNamesIn());
        pack.origin = origin_;
        return pack;
    }

    std::vector<std::string> partNamesIn() {
        std::vector<std::string> names;
        for (Array& a : arrays_) {
            if (a.name() != kPartNamesKey || !a.isText() || a.shape().size() != 1 ||
                a.member.size > kLargestNames)
                continue;
            load(a);
            for (std::uint64_t k = 0; k < a.rows(); ++k) names.push_back(a.text(k));
        }
        return names;
    }

    std::string path_;
    ZipArchive zip_;
    PackReadOptions options_;  ///< with the unit of the file
    PackOrigin origin_;        ///< that its generator states
    std::vector<Array> arrays_;
    std::uint64_t rows_ = 0;
    std::vector<Source> columns_;
};

}  // namespace

Pack<3> readNpz(const std::string& path, const PackReadOptions& options) {
    return NpzFile(path, options).read();
}

}  // namespace vdbpack
