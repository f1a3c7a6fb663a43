// Private to runs: grey values of images as columns of a pack.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/run/domain_source.h"

#include <string>
#include <vector>

namespace vdbpack {

/// Refuses, before the work, samples that are malformed, have the name of another column, or name
/// no image. @return the images. @throws ParameterError, IoError
std::vector<std::string> checkSamples(const std::vector<std::string>& samples);

/// Adds a column for each sample, an image in the world that `domain` says.
/// @throws InputError, IoError, ResourceError
template <int Dim>
void addSamples(const std::vector<std::string>& samples, const DomainRecipe& domain,
                Pack<Dim>& pack, const Callbacks& callbacks);

}  // namespace vdbpack
