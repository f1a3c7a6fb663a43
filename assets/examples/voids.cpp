// A pack with voids, and the morphometry of the solid that they leave.
#include <vdbpack/vdbpack.h>

#include <iostream>

using namespace vdbpack;

int main() {
    const auto bone = ballDomain<3>(10);  // mm
    Pack<3> pack = packSpheres(*bone, PackOptions(SizeDistribution::constant(0.3))).pack;

    BooleanVoids voids;
    voids.shape.radius = SizeDistribution::uniform(0.8, 1.2);
    voids.targetBvtv = 0.3;
    const MadeVoids<3> made = makeVoids(*bone, VoidRecipe{voids});
    keepOnly(pack, spheresOutside(pack.spheres, *made.stamped, Cull::center));

    std::cout << pack.spheres.size() << " spheres\n"
              << summary(measureMorphometry(sampleLevelSet(*made.solid.grid)));
    writePack(pack, "voids.csv");
}
