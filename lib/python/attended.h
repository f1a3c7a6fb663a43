// Runs that Python can interrupt.
#pragma once

#include "cli/option_names.h"

#include "vdbpack/core/progress.h"

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
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

    /// What `work(callbacks)` returns. @throws what it does; what Python raised meanwhile
    template <class Work>
    auto run(const Work& work) {
        std::optional<std::decay_t<decltype(work(Callbacks{}))>> result;
        std::exception_ptr failure;
        std::unique_ptr<py::error_already_set> raised;
        {
            const py::gil_scoped_release released;
            {
                const Listed listed(*this);
                Joining worker;  // however this ends
                worker.onEnd = [this] { cancelled_ = true; };
                worker.thread = std::thread([&] {
                    try {
                        result.emplace(work(callbacks()));
                    } catch (...) {
                        failure = std::current_exception();
                    }
                    const std::lock_guard<std::mutex> lock(mutex_);
                    done_ = true;
                    news_.notify_one();
                });
                while (!attend(raised)) {
                }
                worker.onEnd = nullptr;
            }
            if (!hearsSignals_) stayWhilePythonEnds();
        }
        if (raised) throw py::error_already_set(std::move(*raised));
        if (failure) std::rethrow_exception(failure);
        return std::move(*result);
    }

    /// Ends all runs, when Python exits: their threads must not outlive what they use.
    static void stopAll() {
        const py::gil_scoped_release released;
        std::unique_lock<std::mutex> lock(listMutex());
        // A run of the main thread, which calls this, has ended.
        isLeaving() = true;
        for (Attended* run : list()) run->cancelled_ = true;
        constexpr auto kPatience = std::chrono::seconds(10);
        listEmpty().wait_for(lock, kPatience, [] { return list().empty(); });
    }

private:
    // What runs just now, for `stopAll` alone.
    static std::set<Attended*>& list() {
        static std::set<Attended*> runs;
        return runs;
    }
    static std::mutex& listMutex() {
        static std::mutex mutex;
        return mutex;
    }
    static std::condition_variable& listEmpty() {
        static std::condition_variable empty;
        return empty;
    }
    struct Listed {
        explicit Listed(Attended& run) : run_(run) {
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
        Attended& run_;
    };

    struct Joining {
        std::function<void()> onEnd;
        std::thread thread;
        ~Joining() {
            if (onEnd) onEnd();
            thread.join();
        }
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
        callbacks.cancelled = [this] { return cancelled_.load(); };
        callbacks.warning = [this](const std::string& text) {
            const std::lock_guard<std::mutex> lock(mutex_);
            warnings_.push_back(withOptionNames(text));
        };
        if (!progress_.is_none())
            callbacks.progress = [this](const Progress& p) {
                const std::lock_guard<std::mutex> lock(mutex_);
                latest_ = p;
            };
        return callbacks;
    }

    /// @return whether the work has ended
    bool attend(std::unique_ptr<py::error_already_set>& raised) {
        constexpr auto kOften = std::chrono::milliseconds(50);
        bool ended = false;
        std::optional<Progress> latest;
        std::vector<std::string> warnings;
        {
            std::unique_lock<std::mutex> lock(mutex_);
            ended = news_.wait_for(lock, kOften, [this] { return done_; });
            latest = std::exchange(latest_, std::nullopt);
            warnings = std::exchange(warnings_, {});
        }
        if (!hearsSignals_ && isPythonEnding()) cancelled_ = true;
        const bool hasNews = !warnings.empty() || (latest && !ended);
        if (raised || cancelled_ || !(hasNews || (hearsSignals_ && !ended))) return ended;
        const py::gil_scoped_acquire held;
        try {
            if (hearsSignals_ && !ended && PyErr_CheckSignals() != 0) throw py::error_already_set();
            for (const std::string& text : warnings)
                py::module_::import("vdbpack._errors").attr("warn")(text);
            if (latest && !ended) progress_(latest->stage, latest->fraction, latest->count);
        } catch (py::error_already_set& e) {
            raised = std::make_unique<py::error_already_set>(std::move(e));
            cancelled_ = true;
        }
        return ended;
    }

    py::object progress_;
    bool hearsSignals_ = false;  // only the main thread does
    std::mutex mutex_;
    std::condition_variable news_;
    bool done_ = false;
    std::atomic<bool> cancelled_{false};
    std::optional<Progress> latest_;
    std::vector<std::string> warnings_;
};

}  // namespace vdbpack
