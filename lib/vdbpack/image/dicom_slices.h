// Private to image: where the slices of DICOM files lie, and what their numbers stand for.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/image/image.h"
#include "vdbpack/io/byte_order.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace vdbpack {

/// A slice: the image of a file, or one of its frames.
struct DicomSlice {
    std::string file;
    std::size_t frame = 0, frames = 1;      ///< in its file
    std::array<std::size_t, 2> size{};      ///< columns, rows
    std::array<Vec<3>, 2> along{};          ///< unit vectors, from column to column, row to row
    Vec<3> position;                        ///< mm, of its first pixel
    bool oriented = false, placed = false;  ///< whether the file states directions, a position
    bool stacked = false;                   ///< a frame at an unknown distance from the one before
    Vec<2> spacing;                         ///< mm, of columns and rows; 0: not stated
    double between = 0;                     ///< mm, of slices; 0: not stated
    std::string stack;                      ///< the volume that it belongs to
    NumberType type = NumberType::u8;       ///< as stored
    double slope = 1, intercept = 0;        ///< value = slope * number + intercept
    bool segmented = false;                 ///< of a segmentation, whose segment is this:
    std::size_t segment = 0;                ///< number; 0: of each pixel, its value

    /// The file, and of several frames the number from 1.
    std::string name() const;
};

/// Names of the segments, and how a pixel states its segment.
struct DicomSegments {
    std::vector<LabelName> names;  ///< of segments by their numbers
    bool ofBits = false;           ///< eight pixels in a byte
    std::size_t whole = 1;         ///< the pixel of a voxel that lies in a segment altogether
};

/// @param file  that `checkDicom` has passed. @throws InputError
DicomSegments dicomSegments(const std::string& file);

/// The slices of a file, as stored. Of files with several frames, positions, directions, spacing
/// and scale are those of the functional groups of each frame, else of all frames, else of the
/// file. Pixels are not read.
/// @param file  that `checkDicom` has passed. @throws InputError
std::vector<DicomSlice> dicomSlices(const std::string& file);

}  // namespace vdbpack
