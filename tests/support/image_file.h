// Images made by tests, as files.
#pragma once

#include "vdbpack/image/image_grid.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace vdbpack::test {

/// Calls `work(number, center)` for each voxel of a grid, in their order.
template <class Work>
void forEachVoxel(const ImageGrid& grid, const Work& work) {
    std::size_t i = 0;
    for (std::size_t z = 0; z < grid.size[2]; ++z)
        for (std::size_t y = 0; y < grid.size[1]; ++y)
            for (std::size_t x = 0; x < grid.size[0]; ++x)
                work(i++, grid.at({{static_cast<double>(x), static_cast<double>(y),
                                    static_cast<double>(z)}}));
}

/// Numbers at the voxels of a grid.
template <class T>
struct Voxels {
    ImageGrid grid;
    std::vector<T> values;

    /// Sets each voxel to `valueAt(point)`, mm.
    template <class F>
    static Voxels of(const ImageGrid& grid, const F& valueAt) {
        Voxels v{grid, std::vector<T>(grid.voxels())};
        forEachVoxel(grid, [&](std::size_t i, const Vec<3>& p) {
            v.values[i] = static_cast<T>(valueAt(p));
        });
        return v;
    }
};

/// Cubes of a grid around the origin, turned by no angle.
inline ImageGrid gridAround(double halfWidth, const Vec<3>& spacing, const Vec<3>& shift = {}) {
    ImageGrid grid;
    for (int d = 0; d < 3; ++d) {
        const auto k = static_cast<std::size_t>(d);
        grid.size[k] = static_cast<std::size_t>(2 * halfWidth / spacing[d]) + 4;
        grid.step[k] = {};
        grid.step[k][d] = spacing[d];
        grid.origin[d] = (shift[d] - 0.5 * (static_cast<double>(grid.size[k]) - 1)) * spacing[d];
    }
    return grid;
}

/// Turns a grid about the origin, about x and then z, by angles in radians.
ImageGrid turned(const ImageGrid& grid, double aboutX, double aboutZ);

template <class T>
std::string bytesOfValues(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

inline void writeBytes(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string numberText(const Vec<3>& v) {
    std::ostringstream text;
    text.precision(17);
    text << v[0] << ' ' << v[1] << ' ' << v[2];
    return text.str();
}

/// MetaImage, one file.
template <class T>
void writeMeta(const std::string& path, const Voxels<T>& v, const std::string& type) {
    const Vec<3> s = v.grid.spacing();
    std::string text =
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = "
        "False\nTransformMatrix =";
    for (std::size_t k = 0; k < 3; ++k) text += ' ' + numberText(v.grid.step[k] * (1 / s.c[k]));
    text += "\nOffset = " + numberText(v.grid.origin) + "\nElementSpacing = " + numberText(s) +
            "\nDimSize = " + std::to_string(v.grid.size[0]) + ' ' + std::to_string(v.grid.size[1]) +
            ' ' + std::to_string(v.grid.size[2]) + "\nElementType = " + type +
            "\nElementDataFile = LOCAL\n";
    writeBytes(path, text + bytesOfValues(v.values));
}

/// NRRD, one file. @param further  lines of the header.
template <class T>
void writeNrrd(const std::string& path, const Voxels<T>& v, const std::string& type,
               const std::string& further = "") {
    const auto vector = [](const Vec<3>& x) {
        std::string text = '(' + numberText(x) + ')';
        for (char& c : text)
            if (c == ' ') c = ',';
        return text;
    };
    const auto& g = v.grid;
    writeBytes(path,
               "NRRD0004\ntype: " + type + "\ndimension: 3\nspace: left-posterior-superior\n" +
                   "sizes: " + std::to_string(g.size[0]) + ' ' + std::to_string(g.size[1]) + ' ' +
                   std::to_string(g.size[2]) + "\nspace directions: " + vector(g.step[0]) + ' ' +
                   vector(g.step[1]) + ' ' + vector(g.step[2]) +
                   "\nkinds: domain domain domain\nendian: little\nencoding: raw\n" +
                   "space origin: " + vector(g.origin) + '\n' + further + '\n' +
                   bytesOfValues(v.values));
}

/// The header of a NIfTI-1 file in its 352 bytes, with an sform; `type` is its code.
template <class T>
std::string niftiHeader(const Voxels<T>& v, std::int16_t type) {
    std::string header(352, '\0');
    const auto put = [&](std::size_t at, auto value) {
        header.replace(at, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
    };
    const auto& g = v.grid;
    const Vec<3> s = g.spacing();
    put(0, std::int32_t{348});
    put(40, std::int16_t{3});
    for (std::size_t d = 0; d < 7; ++d)
        put(42 + 2 * d, static_cast<std::int16_t>(d < 3 ? g.size[d] : 1));
    put(70, type);
    put(72, static_cast<std::int16_t>(8 * sizeof(T)));
    put(76, 1.0f);
    for (std::size_t d = 0; d < 3; ++d) put(80 + 4 * d, static_cast<float>(s.c[d]));
    put(108, 352.0f);
    put(123, char{2});  // mm
    put(254, std::int16_t{1});
    for (std::size_t row = 0; row < 3; ++row) {
        const double sign = row < 2 ? -1 : 1;  // RAS
        for (std::size_t d = 0; d < 3; ++d)
            put(280 + 16 * row + 4 * d, static_cast<float>(sign * g.step[d].c[row]));
        put(292 + 16 * row, static_cast<float>(sign * g.origin.c[row]));
    }
    header.replace(344, 4, std::string("n+1\0", 4));
    return header;
}

template <class T>
void writeNifti(const std::string& path, const Voxels<T>& v, std::int16_t type) {
    writeBytes(path, niftiHeader(v, type) + bytesOfValues(v.values));
}

inline ImageGrid turned(const ImageGrid& grid, double aboutX, double aboutZ) {
    const auto turn = [&](const Vec<3>& p) {
        const Vec<3> q{{p[0], std::cos(aboutX) * p[1] - std::sin(aboutX) * p[2],
                        std::sin(aboutX) * p[1] + std::cos(aboutX) * p[2]}};
        return Vec<3>{{std::cos(aboutZ) * q[0] - std::sin(aboutZ) * q[1],
                       std::sin(aboutZ) * q[0] + std::cos(aboutZ) * q[1], q[2]}};
    };
    ImageGrid result = grid;
    result.origin = turn(grid.origin);
    for (std::size_t k = 0; k < 3; ++k) result.step[k] = turn(grid.step[k]);
    return result;
}

/// A label map of a ball on an oblique grid: labels 5 and 9, with an askew plane between them.
inline void writeHalves(const std::string& path) {
    const ImageGrid grid = turned(gridAround(14, {{1, 1, 1.3}}), 0.3, 0.5);
    writeNrrd(path,
              Voxels<std::uint8_t>::of(grid,
                                       [](const Vec<3>& p) {
                                           if (length(p) > 12) return 0;
                                           return p[0] + 0.5 * p[2] < 1 ? 5 : 9;
                                       }),
              "uint8");
}

}  // namespace vdbpack::test
