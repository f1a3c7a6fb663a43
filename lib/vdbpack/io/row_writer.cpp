#include "vdbpack/io/row_writer.h"

#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <vector>

namespace vdbpack {

void writeRows(OutputFile& out, std::size_t rows,
               const std::function<void(std::string&, std::size_t)>& append) {
    writeRows([&out](const std::string& text) { out.write(text); }, rows, append);
}

void writeRows(const std::function<void(const std::string&)>& write, std::size_t rows,
               const std::function<void(std::string&, std::size_t)>& append) {
    constexpr std::size_t kRowsPerChunk = 8192;
    constexpr std::size_t kChunks = 64;
    std::vector<std::string> chunks(kChunks);
    for (std::size_t first = 0; first < rows; first += kRowsPerChunk * kChunks) {
        parallelFor(std::size_t{0}, kChunks, [&](std::size_t c) {
            chunks[c].clear();
            const std::size_t begin = std::min(rows, first + c * kRowsPerChunk);
            const std::size_t end = std::min(rows, begin + kRowsPerChunk);
            for (std::size_t row = begin; row < end; ++row) append(chunks[c], row);
        });
        for (const auto& chunk : chunks) write(chunk);
    }
}

}  // namespace vdbpack
