#include "vdbpack/io/suggest.h"

#include "vdbpack/io/text.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace vdbpack {

std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
        before = last;
        last = row;
    }
    return last[b.size()];
}

std::string mostLike(const std::string& word, const std::vector<std::string>& words) {
    std::string best;
    std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const auto& known : words) {
        const std::size_t distance = editDistance(word, known);
        if (distance < least) {
            least = distance;
            best = known;
        }
    }
    if (!best.empty() || word.size() < 3) return best;
    for (const auto& known : words)
        if (known.compare(0, word.size(), word) == 0) return known;
    return {};
}

std::string similarWord(const std::string& word, const std::vector<std::string>& words) {
    std::vector<std::string> small;
    for (const std::string& each : words) small.push_back(lowered(each));
    const std::string like = mostLike(lowered(word), small);
    const auto found = std::find(small.begin(), small.end(), like);
    return like.empty()
               ? ""
               : " (did you mean " + words[static_cast<std::size_t>(found - small.begin())] + "?)";
}

std::string similarFile(const std::string& path) {
    const std::filesystem::path wanted = path;
    const auto folder = wanted.parent_path();
    std::vector<std::string> names;
    std::error_code failed;
    std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, failed);
    for (; !failed && entry != std::filesystem::directory_iterator(); entry.increment(failed))
        names.push_back(entry->path().filename().string());
    std::sort(names.begin(), names.end());
    const auto twin = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
        return std::filesystem::path(name).stem() == wanted.stem();
    });
    const std::string like =
        twin != names.end() ? *twin : mostLike(wanted.filename().string(), names);
    return like.empty() ? "" : "; did you mean " + (folder / like).string() + "?";
}

}  // namespace vdbpack
