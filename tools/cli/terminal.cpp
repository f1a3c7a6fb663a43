#include "cli/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace {

constexpr std::size_t kNarrow = 60, kWide = 120, kPage = 80;

}  // namespace

bool isTerminal(int stream) {
    return ::isatty(stream) != 0;
}

bool hasColor(int stream) {
    const char* const none = std::getenv("NO_COLOR");
    const char* const term = std::getenv("TERM");
    return isTerminal(stream) && (none == nullptr || *none == 0) &&
           (term == nullptr || std::string_view(term) != "dumb");
}

std::size_t columnsOf(int stream) {
    winsize size{};
    if (::isatty(stream) == 0 || ::ioctl(stream, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
        return kPage;
    return std::clamp<std::size_t>(size.ws_col, kNarrow, kWide);
}

std::string styled(const std::string& text, Style style, int stream) {
    if (!hasColor(stream)) return text;
    const char* const code = style == Style::bold     ? "1"
                             : style == Style::red    ? "1;31"
                             : style == Style::yellow ? "33"
                                                      : "32";
    return std::string("\x1b[") + code + "m" + text + "\x1b[0m";
}
