// Runs vdb_pack in the background, so that tests can interrupt and kill it.
#pragma once

#include "support/paths.h"

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace vdbpack::test {

inline void sleepFor(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// vdb_pack in the background, without output. It is killed if a test ends without waiting for it.
class Process {
public:
    explicit Process(const std::vector<std::string>& arguments) {
        std::vector<std::string> all{kTool};
        all.insert(all.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (std::string& a : all) argv.push_back(a.data());
        argv.push_back(nullptr);
        id_ = ::fork();
        REQUIRE(id_ >= 0);
        if (id_ == 0) {
            const int nowhere = ::open("/dev/null", O_RDWR);
            for (const int standard : {0, 1, 2}) ::dup2(nowhere, standard);
            ::execv(argv[0], argv.data());
            ::_exit(127);
        }
    }
    ~Process() {
        if (id_ <= 0) return;
        ::kill(id_, SIGKILL);
        ::waitpid(id_, nullptr, 0);
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    double seconds() const {
        return std::chrono::duration<double>(Clock::now() - started_).count();
    }
    pid_t id() const { return id_; }
    void signal(int number) { ::kill(id_, number); }
    /// @return the exit code; 128 + number, as in a shell, if a signal ended the process.
    int wait() {
        int status = 0;
        REQUIRE(::waitpid(id_, &status, 0) == id_);
        id_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point started_ = Clock::now();
    pid_t id_ = -1;
};

}  // namespace vdbpack::test
