// How a long computation talks to its caller.
#pragma once

#include <functional>
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
    void warn(const std::string& text) const {
        if (warning) warning(text);
    }
    void report(const char* stage, double fraction, double count) const {
        if (progress) progress({stage, fraction, count});
    }
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
