// Runs of one recipe with several seeds, and what they have in common.
#pragma once

#include "vdbpack/report/study_table.h"
#include "vdbpack/run/run.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

struct StudyResult {
    std::vector<Report> reports;  ///< one a seed, in their order
    bool passed = true;           ///< no check failed in any run
    bool interrupted = false;     ///< `reports` are of the runs before that
    std::string failures;         ///< of all runs
};

/// A pack for each seed, as `runPack` makes it; the domain is made once.
/// @param recipe  names of outputs and of the report may hold {seed}, and must with several seeds.
/// @param table   .csv with a row a run (`studyTable`); empty: none.
/// @throws as runPack; ParameterError for names that runs would share.
StudyResult runStudy(const PackRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});
/// The same of voids, as `runVoids` makes them; the domain is read once.
StudyResult runStudy(const VoidsRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});

/// For people: a line a run, then mean and standard deviation over the runs.
std::string summary(const StudyResult& study);

}  // namespace vdbpack
