// Private to report: words that differ between the plane and space.
#pragma once

#include "vdbpack/core/sphere.h"

#include <string>

namespace vdbpack {

struct DimensionWords {
    explicit DimensionWords(int dim)
        : sphere(dim == 2 ? Measure<2>::kSphere : Measure<3>::kSphere),
          spheres(dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres),
          volume(dim == 2 ? Measure<2>::kVolume : Measure<3>::kVolume),
          volumeUnit(dim == 2 ? Measure<2>::kVolumeUnit : Measure<3>::kVolumeUnit),
          wallUnit(dim == 2 ? "mm" : "mm²") {}

    std::string sphere, spheres;
    std::string volume, volumeUnit;
    std::string wallUnit;
};

}  // namespace vdbpack
