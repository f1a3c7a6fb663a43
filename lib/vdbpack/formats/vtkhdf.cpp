#include "vdbpack/formats/vtkhdf.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/hdf5_handle.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/text.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string_view>
#include <type_traits>

namespace vdbpack {

namespace {

template <class T>
constexpr NumberType typeOf() {
    if constexpr (std::is_floating_point_v<T>)
        return sizeof(T) == 4 ? NumberType::f32 : NumberType::f64;
    else
        return sizeof(T) == 4 ? NumberType::i32 : NumberType::i64;
}

hid_t nativeType(NumberType type) {
    switch (type) {
        case NumberType::i32:
            return H5T_NATIVE_INT32;
        case NumberType::i64:
            return H5T_NATIVE_INT64;
        case NumberType::f32:
            return H5T_NATIVE_FLOAT;
        default:
            return H5T_NATIVE_DOUBLE;
    }
}

/// The format that every HDF5 reads, which is no longer the default of HDF5 2: there, groups have
/// times, and no two files of a pack are the same.
Hdf5 oldestFormat() {
    Hdf5 access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_LATEST);
    return access;
}

class HdfWriter {
public:
    explicit HdfWriter(const std::string& path)
        : path_(path),
          file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, oldestFormat()), H5Fclose),
          group_(made(H5Gcreate2(file_, "VTKHDF", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                 H5Gclose),
          data_(made(H5Gcreate2(group_, "PointData", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                H5Gclose),
          creation_(H5Pcreate(H5P_DATASET_CREATE), H5Pclose) {
        // The same pack gives the same bytes at any time.
        made(H5Pset_obj_track_times(creation_, false));
        // Room for all values at once, which are not set to zero first.
        made(H5Pset_layout(creation_, H5D_CONTIGUOUS));
        made(H5Pset_alloc_time(creation_, H5D_ALLOC_TIME_EARLY));
        made(H5Pset_fill_time(creation_, H5D_FILL_TIME_NEVER));
        const hsize_t two = 2;
        const std::array<std::int64_t, 2> version{1, 0};
        const Hdf5 space(H5Screate_simple(1, &two, nullptr), H5Sclose);
        const Hdf5 attribute(
            made(H5Acreate2(group_, "Version", H5T_NATIVE_INT64, space, H5P_DEFAULT, H5P_DEFAULT)),
            H5Aclose);
        made(H5Awrite(attribute, H5T_NATIVE_INT64, version.data()));
        note("Type", "UnstructuredGrid");
    }
    void note(const char* name, const std::string& text) {
        if (text.empty()) return;
        const Hdf5 type(H5Tcopy(H5T_C_S1), H5Tclose);
        made(H5Tset_size(type, text.size()));
        made(H5Tset_strpad(type, H5T_STR_NULLPAD));
        const Hdf5 space(H5Screate(H5S_SCALAR), H5Sclose);
        const Hdf5 attribute(made(H5Acreate2(group_, name, type, space, H5P_DEFAULT, H5P_DEFAULT)),
                             H5Aclose);
        made(H5Awrite(attribute, type, text.data()));
    }
    void numbers(const char* name, const std::vector<std::int64_t>& values) {
        const hsize_t size = values.size();
        const Hdf5 space(H5Screate_simple(1, &size, nullptr), H5Sclose);
        const Hdf5 set(made(H5Dcreate2(group_, name, H5T_NATIVE_INT64, space, H5P_DEFAULT,
                                       creation_, H5P_DEFAULT)),
                       H5Dclose);
        made(H5Dwrite(set, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
    }
    /// @return the offset of its values.
    std::uint64_t room(const char* name, hid_t type, std::uint64_t rows, std::uint64_t columns = 1,
                       bool ofPoints = false) {
        const std::array<hsize_t, 2> size{rows, columns};
        const Hdf5 space(H5Screate_simple(columns > 1 ? 2 : 1, size.data(), nullptr), H5Sclose);
        const Hdf5 set(made(H5Dcreate2(ofPoints ? data_ : group_, name, type, space, H5P_DEFAULT,
                                       creation_, H5P_DEFAULT)),
                       H5Dclose);
        return rows > 0 ? H5Dget_offset(set) : 0;
    }
    void finish() { made(H5Fflush(file_, H5F_SCOPE_GLOBAL)); }

private:
    template <class Result>
    Result made(Result result) const {
        if (result < 0) throw IoError(path_ + ": writing failed; is the disk full?");
        return result;
    }

    std::string path_;
    Hdf5 file_, group_, data_, creation_;
};

}  // namespace

std::vector<NumberColumn> numberColumns(const PackView& pack) {
    std::vector<NumberColumn> columns{{"radius", NumberType::f64}, {"id", NumberType::i64}};
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            columns.push_back({std::string(name), typeOf<ValueOf<decltype(numbers)>>()});
        },
        [](std::string_view, const auto&) {});
    return columns;
}

std::string vtkNameOf(NumberType type) {
    std::string name = nameOf(type);
    name[0] = isReal(type) ? 'F' : 'I';
    return name;
}

std::uint64_t bytesOfVtkHdf(std::uint64_t points, const std::vector<NumberColumn>& columns) {
    std::uint64_t each = 3 * sizeof(double) + 1 + 2 * sizeof(std::int64_t);
    for (const NumberColumn& column : columns) each += bytesOf(column.type);
    return points * each;
}

VtkHdfOffsets layOutVtkHdf(const std::string& path, const std::vector<std::uint64_t>& pieces,
                           const std::vector<NumberColumn>& columns, Unit unit,
                           const std::string& generator, const std::string& partNames) {
    // After a write that failed, the library crashes at the end of the process.
    H5dont_atexit();
    const Hdf5Quiet quiet;
    const std::uint64_t points = std::accumulate(pieces.begin(), pieces.end(), std::uint64_t{0});
    HdfWriter file(path);
    file.note(kUnitKey, unitName(unit));
    file.note(kGeneratorKey, oneLine(generator));
    constexpr std::size_t kMostNoted = 60000;  // bytes that an attribute can have
    if (partNames.size() < kMostNoted) file.note(kPartNamesKey, partNames);
    const std::vector<std::int64_t> counts(pieces.begin(), pieces.end());
    for (const char* name : {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"})
        file.numbers(name, counts);
    VtkHdfOffsets offsets;
    offsets.points = file.room("Points", H5T_NATIVE_DOUBLE, points, 3);
    offsets.types = file.room("Types", H5T_NATIVE_UINT8, points);
    offsets.connectivity = file.room("Connectivity", H5T_NATIVE_INT64, points);
    offsets.offsets = file.room("Offsets", H5T_NATIVE_INT64, points + pieces.size());
    UniqueNames unique;
    for (const NumberColumn& column : columns) {
        // To HDF5, '/' and '.' are paths.
        std::string name = column.name;
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c == '/' || c == '.'; }, '_');
        name = unique(name);
        offsets.columns.push_back(
            file.room(name.c_str(), nativeType(column.type), points, 1, true));
    }
    file.finish();
    return offsets;
}

}  // namespace vdbpack
