#include "vdbpack/image/text_header.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

/// ITK's reader of NRRD quotes lines in buffers of a fixed size, which overflow from about 700.
constexpr std::size_t kLongestLine = 500;

/// A whole number, 0 for anything else.
std::int64_t wholeOf(const std::string& text) {
    std::int64_t value = 0;
    return parseInteger(text, value) ? value : 0;
}

}  // namespace

std::string TextHeader::value(const std::string& key) const {
    const auto at = lines.lower_bound(key);
    return at == lines.end() || at->first != key ? "" : at->second;
}

TextHeader readTextHeader(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw IoError(path + ": cannot be opened for reading");
    std::string text(std::min<std::uint64_t>(sizeOf(path), std::uint64_t{1} << 20), ' ');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
    TextHeader header;
    while (header.end < text.size()) {
        const std::size_t end = std::min(text.find('\n', header.end), text.size());
        const std::string_view line =
            trimmed(std::string_view(text).substr(header.end, end - header.end));
        header.end = std::min(end + 1, text.size());
        if (line.empty() && !header.lines.empty()) break;
        const std::size_t mark = line.find_first_of(":=");
        const bool free = mark != std::string_view::npos && startsWith(line.substr(mark), ":=");
        if (!free && !startsWith(line, "#")) header.longest = std::max(header.longest, line.size());
        if (mark == std::string_view::npos) continue;
        std::string key = lowered(trimmed(line.substr(0, mark)));
        const bool last = key == "elementdatafile";
        header.lines.emplace(std::move(key),
                             std::string(trimmed(line.substr(mark + (free ? 2 : 1)))));
        if (last) break;
    }
    return header;
}

std::vector<LabelName> labelNames(const TextHeader& header) {
    std::vector<LabelName> names;
    for (int k = 0;; ++k) {
        const std::string segment = "segment" + std::to_string(k) + "_";
        LabelName label;
        label.name = header.value(segment + "name");
        const std::string value = header.value(segment + "labelvalue");
        if (label.name.empty() && value.empty()) break;
        label.value = wholeOf(value);
        label.layer = static_cast<std::size_t>(
            std::max(std::int64_t{0}, wholeOf(header.value(segment + "layer"))));
        names.push_back(label);
    }
    return names;
}

void checkNrrdHeader(const TextHeader& header, const std::string& path) {
    if (header.longest > kLongestLine)
        throw InputError(
            fmt::format("{}: a line of its header has {} bytes, at most {} can be read; it is "
                        "damaged, or shorten that line",
                        path, header.longest, kLongestLine));
}

std::uint64_t bytesOfData(const TextHeader& header, const std::string& path) {
    std::string data = header.value("data file");
    if (data.empty()) data = header.value("datafile");
    if (data.empty()) return sizeOf(path);
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    // Of a list or a pattern, all files in the folder.
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder / data, ignored))
        return sizeOf((folder / data).string());
    std::uint64_t sum = 0;
    const std::filesystem::path shown = folder.empty() ? std::filesystem::path(".") : folder;
    for (const auto& entry : std::filesystem::directory_iterator(shown, ignored))
        if (entry.is_regular_file(ignored)) sum += entry.file_size(ignored);
    return sum;
}

}  // namespace vdbpack
