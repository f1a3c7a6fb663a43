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
    /// @param exitCode  of this process, not 0: it failed, and the others may wait for it. Then all
    ///                  are ended with it at once. @param tell  tells the error; where all failed
    ///                  alike, the first process alone does.
    virtual void end(int exitCode, const std::function<void()>& tell) = 0;
};

/// @return null where this process was started alone.
/// @throws vdbpack::ParameterError where there are several, but the program was built without MPI.
std::unique_ptr<RankSession> startRanks();
