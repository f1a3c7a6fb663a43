// Private: rows of a file, composed in parallel.
#pragma once

#include "vdbpack/io/output_file.h"

#include <cstddef>
#include <functional>
#include <string>

namespace vdbpack {

/// Writes rows 0 to `rows` - 1 in order; `append(text, row)` adds one row to `text` and is called
/// from several threads. @throws IoError
void writeRows(OutputFile& out, std::size_t rows,
               const std::function<void(std::string&, std::size_t)>& append);
/// The same for rows that go elsewhere: `write` gets several at a time, in order.
void writeRows(const std::function<void(const std::string&)>& write, std::size_t rows,
               const std::function<void(std::string&, std::size_t)>& append);

}  // namespace vdbpack
