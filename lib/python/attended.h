// Runs that Python can interrupt.
#pragma once

#include "arrays.h"

#include "vdbpack/core/progress.h"

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace py = pybind11;

/// Works on another thread, while this one listens to signals and tells progress.
class Attended {
public:
    /// @param progress  called with a stage, its share that is done and a count; or None
    explicit Attended(py::object progress) : progress_(std::move(progress)) {
        const py::module_ threading = py::module_::import("threading");
        hearsSignals_ = threading.attr("current_thread")().is(threading.attr("main_thread")());
    }

    /// What `work(callbacks)` returns. Once Python has raised, the work is cancelled; where it does
    /// not end soon, it ends in the background.
    /// @param work  a copy of it is called. It owns what it needs, and nothing of Python's.
    /// @throws what it does; what Python raised meanwhile
    template <class Work>
    auto run(const Work& work) {
        struct Result {
            std::optional<std::decay_t<decltype(work(Callbacks{}))>> value;
            std::exception_ptr failure;
        };
        const auto result = std::make_shared<Result>();
        std::unique_ptr<py::error_already_set> raised;
        {
            const py::gil_scoped_release released;
            auto listed = std::make_shared<Listed>(*run_);
            std::thread worker(
                [run = run_, result, work, listed = std::move(listed), callbacks = callbacks()] {
                    try {
                        result->value.emplace(work(callbacks));
                    } catch (...) {
                        result->failure = std::current_exception();
                    }
                    const std::lock_guard<std::mutex> lock(run->mutex);
                    run->done = true;
                    run->news.notify_one();
                });
            if (attend(raised))
                worker.join();
            else
                worker.detach();
            if (!hearsSignals_) stayWhilePythonEnds();
        }
        if (raised) throw py::error_already_set(std::move(*raised));
        if (result->failure) std::rethrow_exception(result->failure);
        return std::move(*result->value);
    }

    /// Ends all runs, when Python exits: their threads must not outlive what they use.
    static void stopAll() {
        const py::gil_scoped_release released;
        std::unique_lock<std::mutex> lock(listMutex());
        // A run of the main thread, which calls this, has ended.
        isLeaving() = true;
        for (Run* run : list()) run->cancelled = true;
        constexpr auto kPatience = std::chrono::seconds(10);
        listEmpty().wait_for(lock, kPatience, [] { return list().empty(); });
    }

private:
    /// What both threads know of a run.
    struct Run {
        std::mutex mutex;
        std::condition_variable news;
        bool done = false;
        std::atomic<bool> cancelled{false};
        std::optional<Progress> latest;
        std::vector<std::string> warnings;
    };

    // What runs just now, for `stopAll` alone; never destroyed, since a run may end last.
    static std::set<Run*>& list() {
        static auto& runs = *new std::set<Run*>;
        return runs;
    }
    static std::mutex& listMutex() {
        static auto& mutex = *new std::mutex;
        return mutex;
    }
    static std::condition_variable& listEmpty() {
        static auto& empty = *new std::condition_variable;
        return empty;
    }
    struct Listed {
        explicit Listed(Run& run) : run_(run) {
            const std::lock_guard<std::mutex> lock(listMutex());
            list().insert(&run_);
        }
        ~Listed() {
            const std::lock_guard<std::mutex> lock(listMutex());
            list().erase(&run_);
            listEmpty().notify_all();
        }
        Listed(const Listed&) = delete;
        Listed& operator=(const Listed&) = delete;

    private:
        Run& run_;
    };

    static std::atomic<bool>& isLeaving() {
        static std::atomic<bool> leaving{false};
        return leaving;
    }

    static bool isPythonEnding() {
        if (isLeaving()) return true;
#if PY_VERSION_HEX >= 0x030d0000
        return Py_IsFinalizing() != 0;
#else
        return _Py_IsFinalizing() != 0;
#endif
    }

    /// A thread that asked for Python's lock then would be ended within a destructor.
    static void stayWhilePythonEnds() {
        while (isPythonEnding()) std::this_thread::sleep_for(std::chrono::hours(1));
    }

    Callbacks callbacks() {
        Callbacks callbacks;
        callbacks.cancelled = [run = run_] { return run->cancelled.load(); };
        callbacks.warning = [run = run_](const std::string& text) {
            const std::lock_guard<std::mutex> lock(run->mutex);
            run->warnings.push_back(text);
        };
        if (!progress_.is_none())
            callbacks.progress = [run = run_](const Progress& p) {
                const std::lock_guard<std::mutex> lock(run->mutex);
                run->latest = p;
            };
        return callbacks;
    }

    /// Until the work has ended. @return false if it has been cancelled and still goes on
    bool attend(std::unique_ptr<py::error_already_set>& raised) {
        constexpr auto kOften = std::chrono::milliseconds(50),
                       kPatience = std::chrono::milliseconds(300);
        std::chrono::steady_clock::time_point since;
        for (;;) {
            bool ended = false;
            std::optional<Progress> latest;
            std::vector<std::string> warnings;
            {
                std::unique_lock<std::mutex> lock(run_->mutex);
                ended = run_->news.wait_for(lock, kOften, [this] { return run_->done; });
                latest = std::exchange(run_->latest, std::nullopt);
                warnings = std::exchange(run_->warnings, {});
            }
            if (!raised) {
                if (!hearsSignals_ && isPythonEnding()) run_->cancelled = true;
                const bool hasNews = !warnings.empty() || (latest && !ended);
                if (!run_->cancelled && (hasNews || (hearsSignals_ && !ended))) {
                    tell(ended ? std::nullopt : latest, warnings, !ended, raised);
                    since = std::chrono::steady_clock::now();
                }
            }
            if (ended) return true;
            if (raised && std::chrono::steady_clock::now() - since > kPatience) return false;
        }
    }

    /// Lets Python hear what is new; what it raises cancels the work.
    void tell(const std::optional<Progress>& latest, const std::vector<std::string>& warnings,
              bool runs, std::unique_ptr<py::error_already_set>& raised) {
        const py::gil_scoped_acquire held;
        try {
            if (hearsSignals_ && runs && PyErr_CheckSignals() != 0) throw py::error_already_set();
            for (const std::string& text : warnings)
                py::module_::import("vdbpack._errors").attr("warn")(shownText(text));
            if (latest) progress_(latest->stage, latest->fraction, latest->count);
        } catch (py::error_already_set& e) {
            raised = std::make_unique<py::error_already_set>(std::move(e));
            run_->cancelled = true;
        }
    }

    py::object progress_;
    bool hearsSignals_ = false;  // only the main thread does
    std::shared_ptr<Run> run_ = std::make_shared<Run>();
};

}  // namespace vdbpack
