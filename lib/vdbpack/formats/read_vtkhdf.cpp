// VTKHDF: unstructured grids and polygon data, of which the points are read.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/hdf5_handle.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::uint64_t kRowsAtATime = 1 << 15;
constexpr std::size_t kLongestWord = 100, kLongestNames = 60000;  ///< of attributes, bytes

/// An array with a row of numbers for each point.
struct Array {
    std::string name;
    Hdf5 set;
    NumberType type = NumberType::f64;  ///< as it is read: i64 or f64
    std::uint64_t rows = 0, components = 1;
    std::uint64_t begin = 0;     ///< row of the first point
    std::vector<char> values{};  ///< of the rows that are read
};

class VtkHdfFile {
public:
    VtkHdfFile(const std::string& path, const PackReadOptions& options)
        : path_(path),
          options_(options),
          file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose),
          group_(file_.isValid() ? H5Gopen2(file_, "VTKHDF", H5P_DEFAULT) : H5I_INVALID_HID,
                 H5Gclose) {
        if (!file_.isValid()) fail("is no HDF5 file, or a damaged one");
        if (!group_.isValid()) fail("has no group VTKHDF; export it as VTKHDF");
        const std::string type = textOf("Type");
        if (type != "UnstructuredGrid" && type != "PolyData")
            fail(fmt::format("holds {}; points are read of an UnstructuredGrid or PolyData",
                             type.empty() ? "no type" : quotedExcerpt(type)));
    }

    Pack<3> read() {
        const std::string named = textOf(kUnitKey);
        if (!named.empty()) options_.unit = unitNamed(named, path_);
        std::vector<Array> arrays;
        arrays.push_back(arrayOf(group_, "Points"));
        if (arrays.front().components != 3) fail("its points do not have three coordinates");
        const Hdf5 data(H5Gopen2(group_, "PointData", H5P_DEFAULT), H5Gclose);
        for (const std::string& name : namesIn(data)) arrays.push_back(arrayOf(data, name));
        std::uint64_t points = arrays.front().rows;
        const bool hasSteps = H5Lexists(group_, "Steps", H5P_DEFAULT) > 0;
        if (hasSteps) points = takeLastStep(arrays);
        for (const Array& array : arrays)
            if (hasSteps ? array.begin + points > array.rows : array.rows != points)
                fail(fmt::format("array {} has {} rows for {} points", quotedExcerpt(array.name),
                                 array.rows, array.begin + points));
        std::vector<std::string> columns{"x", "y", "z"};
        for (std::size_t a = 1; a < arrays.size(); ++a)
            addNames(columns, arrays[a].name, arrays[a].components);
        PackBuilder builder(path_, columns, options_);
        requireMemoryToRead(path_, builder.bytesOf(points), options_.memoryLimit);
        builder.reserve(points);
        for (std::uint64_t first = 0; first < points; first += kRowsAtATime) {
            const std::uint64_t count = std::min(kRowsAtATime, points - first);
            std::vector<PackBuilder::Put> puts;
            for (Array& array : arrays) {
                load(array, first, count);
                for (std::uint64_t c = 0; c < array.components; ++c)
                    puts.push_back(builder.numbersFrom(array.values.data() + 8 * c,
                                                       8 * array.components, array.type, false));
            }
            builder.addRows(count, puts, "point", first);
        }
        Pack<3> pack = builder.finish();
        pack.origin = originIn(textOf(kGeneratorKey));
        if (const std::string names = textOf(kPartNamesKey, kLongestNames); !names.empty())
            setPartNames(pack, splitAt(names, '\n'));
        return pack;
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw InputError(path_ + ": " + what); }

    /// The text of an attribute of the group; empty: there is none.
    std::string textOf(const char* name, std::size_t longest = kLongestWord) const {
        const Hdf5 attribute(
            H5Aexists(group_, name) > 0 ? H5Aopen(group_, name, H5P_DEFAULT) : H5I_INVALID_HID,
            H5Aclose);
        if (!attribute.isValid()) return {};
        const Hdf5 type(H5Aget_type(attribute), H5Tclose);
        const Hdf5 space(H5Aget_space(attribute), H5Sclose);
        if (H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1) return {};
        if (H5Tis_variable_str(type) > 0) {
            char* text = nullptr;
            if (H5Aread(attribute, type, &text) < 0 || !text) return {};
            std::string copy(text);
            H5free_memory(text);
            return copy.substr(0, longest);
        }
        const std::size_t size = H5Tget_size(type);
        if (size > longest) return {};
        std::string text(size, '\0');
        if (H5Aread(attribute, type, text.data()) < 0) return {};
        return text.substr(0, text.find('\0'));
    }

    /// The last number of an array; `otherwise` if there is none.
    std::uint64_t lastOf(hid_t group, const std::string& name, std::uint64_t otherwise) const {
        if (!(group >= 0) || !(H5Lexists(group, name.c_str(), H5P_DEFAULT) > 0)) return otherwise;
        Array array = arrayOf(group, name);
        return array.rows > 0 ? numberOf(array, array.rows - 1) : otherwise;
    }
    std::uint64_t numberOf(Array& array, std::uint64_t row) const {
        load(array, row, 1);
        std::int64_t value = -1;
        if (array.type == NumberType::i64) std::memcpy(&value, array.values.data(), sizeof value);
        if (value < 0 || value > std::int64_t{1} << 48)
            fail(fmt::format("array {} of its steps holds no counts; the file is damaged",
                             quotedExcerpt(array.name)));
        return static_cast<std::uint64_t>(value);
    }
    /// Notes where the points of the last time step begin in the arrays, of which the first are the
    /// coordinates. @return how many they are.
    std::uint64_t takeLastStep(std::vector<Array>& arrays) const {
        const Hdf5 steps(H5Gopen2(group_, "Steps", H5P_DEFAULT), H5Gclose);
        const Hdf5 offsets(H5Gopen2(steps, "PointDataOffsets", H5P_DEFAULT), H5Gclose);
        Array counts = arrayOf(group_, "NumberOfPoints");
        const std::uint64_t parts = lastOf(steps, "NumberOfParts", 1);
        const std::uint64_t part =
            lastOf(steps, "PartOffsets", counts.rows - std::min(counts.rows, parts));
        if (part > counts.rows || parts > counts.rows - part)
            fail("the parts of its last step are missing; the file is damaged");
        std::uint64_t points = 0;
        for (std::uint64_t p = part; p < part + parts; ++p) points += numberOf(counts, p);
        arrays.front().begin = lastOf(steps, "PointOffsets", 0);
        for (std::size_t a = 1; a < arrays.size(); ++a)
            arrays[a].begin = lastOf(offsets, arrays[a].name, arrays.front().begin);
        options_.callbacks.warn(fmt::format(
            "{}: holds several time steps, of which the last is read; export another one alone for "
            "that",
            path_));
        return points;
    }

    std::vector<std::string> namesIn(const Hdf5& data) const {
        std::vector<std::string> names;
        if (!data.isValid()) return names;
        const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
            static_cast<std::vector<std::string>*>(list)->emplace_back(name);
            return 0;
        };
        // In the order in which they were made, where the file knows it.
        if (H5Literate(data, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, add, &names) < 0) {
            names.clear();
            if (H5Literate(data, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) < 0)
                fail("its arrays cannot be listed; the file is damaged");
        }
        return names;
    }

    Array arrayOf(hid_t group, const std::string& name) const {
        Array array{name, Hdf5(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose)};
        if (!array.set.isValid())
            fail(fmt::format("array {} cannot be read; the file is damaged", quotedExcerpt(name)));
        const Hdf5 type(H5Dget_type(array.set), H5Tclose);
        const Hdf5 space(H5Dget_space(array.set), H5Sclose);
        const H5T_class_t kind = H5Tget_class(type);
        if (kind != H5T_INTEGER && kind != H5T_FLOAT)
            fail(fmt::format("array {} holds no numbers; export it without that array",
                             quotedExcerpt(name)));
        array.type = kind == H5T_INTEGER ? NumberType::i64 : NumberType::f64;
        std::array<hsize_t, 2> size{0, 1};
        const int dimensions = H5Sget_simple_extent_ndims(space);
        if ((dimensions != 1 && dimensions != 2) ||
            H5Sget_simple_extent_dims(space, size.data(), nullptr) < 0)
            fail(fmt::format("array {} has {} dimensions; one or two are needed",
                             quotedExcerpt(name), dimensions));
        array.rows = size[0];
        array.components = size[1];
        return array;
    }

    void load(Array& array, std::uint64_t first, std::uint64_t count) const {
        const std::array<hsize_t, 2> start{array.begin + first, 0}, size{count, array.components};
        const Hdf5 here(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
        const Hdf5 there(H5Dget_space(array.set), H5Sclose);
        H5Sselect_hyperslab(there, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
        array.values.resize(8 * count * array.components);
        const hid_t type = array.type == NumberType::i64 ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE;
        const herr_t read = H5Dread(array.set, type, here, there, H5P_DEFAULT, array.values.data());
        if (read < 0)
            fail(fmt::format("rows {} to {} of array {} cannot be read; the file is damaged", first,
                             first + count - 1, quotedExcerpt(array.name)));
    }

    std::string path_;
    PackReadOptions options_;
    Hdf5 file_, group_;
};

}  // namespace

Pack<3> readVtkHdf(const std::string& path, const PackReadOptions& options) {
    { const InputFile readable(path); }
    const Hdf5Quiet quiet;
    return VtkHdfFile(path, options).read();
}

}  // namespace vdbpack
