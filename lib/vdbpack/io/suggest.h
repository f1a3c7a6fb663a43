// What a misspelt word was meant to be.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vdbpack {

/// Insertions, deletions, replacements and swaps of neighbors that turn one word into the other
/// (optimal string alignment).
std::size_t editDistance(const std::string& a, const std::string& b);

/// The word most like `word`, if one is alike: by at most a third of its letters, or beginning with
/// it. Empty if there is none.
std::string mostLike(const std::string& word, const std::vector<std::string>& words);

/// " (did you mean WORD?)" with the word most like another one, whatever their capitals; empty if
/// there is none.
std::string similarWord(const std::string& word, const std::vector<std::string>& words);

/// "; did you mean NAME?" with the file beside `path`, which is not there, whose name is most like
/// its own, or the same but for its extension; empty if there is none.
std::string similarFile(const std::string& path);

}  // namespace vdbpack
