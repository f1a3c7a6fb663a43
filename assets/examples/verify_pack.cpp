// Is a pack of any program sound? Usage: verify_pack PACK MESH, both in mm.
#include <vdbpack/vdbpack.h>

#include <exception>
#include <iostream>

using namespace vdbpack;

int main(int argc, char** argv) try {
    if (argc != 3) throw ParameterError("usage: verify_pack PACK MESH");
    const Pack<3> pack = readPack(argv[1]);
    const TriangleMesh mesh = repairMesh(readMesh(argv[2])).mesh;  // as it is, if it is sound
    const VerifyResult result = verifyPack(pack, mesh);
    std::cout << describe(result, pack);
    if (result.passed()) return 0;

    // Free of overlaps, without changing a radius.
    const auto domain =
        meshDomain(mesh, FieldOptions::forRadii(result.radius.min, result.radius.max));
    Pack<3> mended;
    mended.spheres = densify(*domain, pack.spheres, DensifyOptions{}).spheres;
    writePack(mended, "mended.csv");
    return 1;
} catch (const std::exception& e) {
    std::cerr << e.what() << '\n';
    return 2;
}
