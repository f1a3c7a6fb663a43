#include "rank_session.h"

#include "vdbpack/core/error.h"

#include <cstdlib>
#include <string>

std::unique_ptr<RankSession> startRanks() {
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
        if (const char* const count = std::getenv(name); count && std::atoi(count) > 1)
            throw vdbpack::ParameterError(
                std::string(count) +
                " processes were started, but this program was built without MPI: each would do "
                "the same work. Start one, or install libopenmpi-dev and openmpi-bin, and build "
                "with -DVDBPACK_MPI=ON");
    return nullptr;
}
