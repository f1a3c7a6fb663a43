// Private: whether encoded pixels of a DICOM file are as large as the file says; decoders write
// past their buffers, or end the program, where they are not.
#pragma once

#include "vdbpack/io/input_file.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Where a fragment of pixels lies in its file.
struct DicomFragment {
    std::uint64_t begin = 0, end = 0;
};

struct DicomFrame {
    std::uint64_t rows = 0, columns = 0, samples = 0, allocated = 0;  ///< bits, the last
};

/// Checks the headers of frames. @param syntax  the transfer syntax: run lengths, JPEG, JPEG-LS or
/// JPEG 2000. @param fragments  the first is a table of the others. @throws InputError
void checkPackedPixels(const InputFile& file, const std::string& syntax,
                       const std::vector<DicomFragment>& fragments, const DicomFrame& frame);

}  // namespace vdbpack
