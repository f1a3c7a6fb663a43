// Is a pack of any program sound? Usage: verify_pack PACK MESH, both in mm.
#include <vdbpack/vdbpack.h>

#include <iostream>

using namespace vdbpack;

int main(int argc, char** argv) {
    if (argc != 3) return std::cerr << "usage: verify_pack PACK MESH\n", 2;
    const Pack<3> pack = readPack(argv[1]);
    const TriangleMesh mesh = repairMesh(readMesh(argv[2])).mesh;  // as it is, if it is sound
    const VerifyResult check = verifyPack(pack, mesh);
    std::cout << describe(check, pack);
    if (check.passed()) return 0;

    // Free of overlaps, without changing a radius.
    const auto bone = meshDomain(mesh, FieldOptions::forRadii(check.radius.min, check.radius.max));
    const Pack<3> mended{{}, densify(*bone, pack.spheres, {}).spheres};
    writePack(mended, "mended.csv");
    return 1;
}
