// The processes that mpirun or srun started, as ranks.
#pragma once

#include "vdbpack/core/ranks.h"

#include <functional>
#include <memory>

/// One of several processes; by MPI.
class RankSession {
public:
    virtual ~RankSession() = default;

    virtual vdbpack::Ranks& ranks() = 0;
    /// Threads that suit a process: its share of the cores that it may use.
    virtual int threads() const = 0;
    /// Ends this process's part; to be called last, by all processes.
    /// @param failed  whether this one has an error. Where others have none they may wait for it:
    ///                then `tell` tells it, and all are ended with `exitCode` at once. Where all
    ///                failed alike, the first process alone tells.
    /// @return the exit code of this process: 0 where another one ends with that of all.
    virtual int end(bool failed, int exitCode, const std::function<void()>& tell) = 0;
};

/// @return null where this process was started alone.
/// @throws vdbpack::ParameterError where there are several, but the program was built without MPI.
std::unique_ptr<RankSession> startRanks();
