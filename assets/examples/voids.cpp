// A pack with voids, and the morphometry of the solid that they leave.
#include <vdbpack/vdbpack.h>

#include <iostream>

using namespace vdbpack;

int main() {
    const auto bone = ballDomain<3>(10);  // mm
    Pack<3> pack = packSpheres(*bone, PackOptions(SizeDistribution::constant(0.3))).pack;

    const VoidShape<3> shape{SizeDistribution::uniform(0.8, 1.2), SizeDistribution::constant(2),
                             makeOrientation<3>({"isotropic"}, bone->bounds())};
    const double shell = 1;                                             // mm
    const auto voids = booleanVoids<3>({*bone, shell}, shape, 1, 0.1);  // seed, voids per mm³
    StampOptions<3> stamp;
    stamp.voxelSize = 0.2;
    stamp.origin = fieldOrigin(bone->bounds(), stamp.voxelSize);
    stamp.shell = shell;
    const auto stamped = stampVoids(voids, *bone, stamp);
    keepOnly(pack, spheresOutside(pack.spheres, *stamped, Cull::center));

    const auto solid = cutVoids(*surfaceLevelSet(*bone, 0.2), *stamped->grid(), shell, false);
    const Morphometry bvtv = measureMorphometry(sampleLevelSet(*solid.grid));
    std::cout << pack.spheres.size() << " spheres\n" << summary(bvtv);
    writePack(pack, "voids.csv");
}
