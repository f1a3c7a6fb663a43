// Spheres in memory from a mesh in memory.
#include <vdbpack/vdbpack.h>

#include <cstdio>

using namespace vdbpack;

int main() {
    TriangleMesh bone;  // mm; closed: here a tetrahedron with edges of 57 mm
    bone.vertices = {{{20, 20, 20}}, {{20, -20, -20}}, {{-20, 20, -20}}, {{-20, -20, 20}}};
    bone.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};

    const auto sizes = SizeDistribution::uniform(0.5, 1);  // radii, mm
    const auto domain = meshDomain(bone, sizes);
    const Pack<3> pack = packSpheres(*domain, PackOptions(sizes)).pack;

    std::printf("%zu spheres, solid fraction %.3f\n", pack.spheres.size(),
                solidFraction(pack.spheres, *domain));
    return verifyPack(pack, bone).passed() ? 0 : 1;
}
