// A mesh as a level set of exact distances, in a .vdb file.
#include <vdbpack/field/narrow_band.h>
#include <vdbpack/vdbpack.h>

#include <cstdio>

using namespace vdbpack;

int main(int argc, char** argv) {
    if (argc != 3) return std::fprintf(stderr, "level_set MESH FILE.vdb\n"), 2;
    const TriangleMesh mesh = readMesh(argv[1]);  // mm, closed

    const double voxelSize = 0.5;                         // mm
    const auto grid = narrowBand(mesh, voxelSize, 5, 3);  // voxels inside and outside
    grid->setName("surface");
    openvdb::io::File(argv[2]).write({grid});

    std::printf("%llu active voxels\n", static_cast<unsigned long long>(grid->activeVoxelCount()));
    return grid->empty() ? 1 : 0;
}
