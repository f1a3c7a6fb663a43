// How a long computation talks to its caller.
#pragma once

#include "vdbpack/core/error.h"

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// One report of progress.
struct Progress {
    std::string stage;    ///< "pack", "domain", ...
    double fraction = 0;  ///< share of the stage that is done, 0 to 1
    double count = 0;     ///< things done so far (spheres in stage "pack")
};

/// Callbacks into the caller; each may be empty. They may be called from any thread, one at a time.
struct Callbacks {
    std::function<void(const Progress&)> progress;
    std::function<void(const std::string&)> warning;
    /// Asked often; once it returns true, the computation stops and keeps what is complete.
    std::function<bool()> cancelled;

    bool isCancelled() const { return cancelled && cancelled(); }
    /// @throws Interrupted once `cancelled` says so.
    void stopIfCancelled() const {
        if (isCancelled()) throw Interrupted();
    }
    void warn(const std::string& text) const {
        if (warning) warning(text);
    }
    void report(const char* stage, double fraction, double count) const {
        if (progress) progress({stage, fraction, count});
    }
};

/// Asks `cancelled` on behalf of the threads of one computation, one at a time, and keeps a yes.
class StopRequest {
public:
    /// `cancelled` must outlive this.
    explicit StopRequest(const std::function<bool()>& cancelled) : cancelled_(cancelled) {}

    /// Cheap enough to be asked every tenth of a millisecond by each thread.
    bool made() {
        if (made_.load(std::memory_order_relaxed)) return true;
        if (!cancelled_) return false;
        // Where another thread asks just now, its answer will do for the next time.
        const std::unique_lock<std::mutex> lock(asking_, std::try_to_lock);
        if (lock.owns_lock() && cancelled_()) made_ = true;
        return made_;
    }
    /// @throws Interrupted
    void stop() {
        if (made()) throw Interrupted();
    }

private:
    const std::function<bool()>& cancelled_;
    std::mutex asking_;
    std::atomic<bool> made_{false};
};

/// The same callbacks; warnings are kept in `warnings`, which must outlive them, as well.
inline Callbacks keepingWarnings(Callbacks callbacks, std::vector<std::string>& warnings) {
    callbacks.warning = [&warnings, tell = std::move(callbacks.warning)](const std::string& text) {
        warnings.push_back(text);
        if (tell) tell(text);
    };
    return callbacks;
}

}  // namespace vdbpack
