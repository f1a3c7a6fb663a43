// What a new user meets first: commands to try, and the pack of a bundled bone.
#pragma once

#include "vdbpack/options/jobs.h"

#include <array>
#include <string>

/// A command line to try, and what it does.
struct FirstStep {
    std::string words;  ///< after the name of the program
    std::string effect;
};

const std::array<FirstStep, 3>& firstSteps();

/// The first steps as a text. @param program  as the user called it.
std::string firstStepsText(const std::string& program);

/// The mesh of a femur that comes with the program: installed with it, or in the repository in
/// which it was built. @throws vdbpack::IoError if it is missing.
std::string bundledMesh();

/// The run of `vdb_pack demo`: packs the femur into a folder, which is made if need be.
/// @throws vdbpack::IoError
vdbpack::PackJob demoJob(const std::string& folder);

/// How to open what the demo wrote. @param program  as the user called it.
std::string demoText(const std::string& folder, const std::string& program);
