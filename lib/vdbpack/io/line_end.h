// Where the lines of a text end.
#pragma once

#include <cstddef>
#include <string_view>

namespace vdbpack {

/// So many bytes from the beginning of a text tell how its lines end.
constexpr std::size_t kLineEndSample = 1 << 16;

/// The last character of every line of the text that begins so: '\n' (alone or after '\r'), or
/// '\r' where there is no '\n' in it, as old Mac software writes it.
inline char lineEndOf(std::string_view beginning) {
    beginning = beginning.substr(0, kLineEndSample);
    return beginning.find('\n') == beginning.npos && beginning.find('\r') != beginning.npos ? '\r'
                                                                                            : '\n';
}

}  // namespace vdbpack
