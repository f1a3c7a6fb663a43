#include "cli/open_page.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdlib>

extern char** environ;

namespace {

bool isSet(const char* variable) {
    const char* const value = std::getenv(variable);
    return value != nullptr && *value != '\0';
}

}  // namespace

bool openPage(const std::string& file) {
    if (!isSet("DISPLAY") && !isSet("WAYLAND_DISPLAY")) return false;
    // A name that starts with a dash is no option.
    std::string path = file.rfind('/', 0) == 0 ? file : "./" + file;
    std::string program = "xdg-open";
    char* arguments[] = {program.data(), path.data(), nullptr};
    posix_spawn_file_actions_t actions;
    if (::posix_spawn_file_actions_init(&actions) != 0) return false;
    // Messages of the desktop's programs are not ours.
    for (const int output : {STDOUT_FILENO, STDERR_FILENO})
        ::posix_spawn_file_actions_addopen(&actions, output, "/dev/null", O_WRONLY, 0);
    pid_t child = 0;
    const bool started =
        ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments, environ) == 0;
    ::posix_spawn_file_actions_destroy(&actions);
    return started;
}
