// Private: whether a DICOM file is sound enough for GDCM, which ends the program over many that are
// not.
#pragma once

#include <cstdint>
#include <string>

namespace vdbpack {

/// What a DICOM file is, as far as slices are sorted by it.
struct DicomKind {
    bool dicom = false;        ///< whether it begins as DICOM files do
    bool image = false;        ///< whether it has pixels
    std::uint64_t pixels = 0;  ///< where they begin; 0: they are encoded
    std::string series;        ///< the same for all slices of one volume
};

/// Whether images of a SOP class are segmentations: of bits or fractions, or label maps.
bool isDicomSegmentation(const std::string& sopClass);

/// Walks the elements of a file: their representations, their lengths, and the values that place
/// and size the image. Files that are not DICOM are not read further. Cost: one small read for each
/// element.
/// @throws InputError for one that is damaged or of an encoding that cannot be read, IoError
DicomKind checkDicom(const std::string& path);

}  // namespace vdbpack
