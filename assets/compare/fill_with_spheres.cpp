// Fills a box or a closed mesh with openvdb::tools::fillWithSpheres and writes x, y, z, radius.
//
//   fill_with_spheres DOMAIN LOW HIGH OUT.csv [VOXEL [INSTANCES]]
//
// DOMAIN is box:SIDE, about the origin, or an .off file of triangles; radii lie between LOW and
// HIGH. VOXEL is LOW / 4 by default, INSTANCES 100000. Lengths in the unit of DOMAIN. Uses one
// thread.
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToSpheres.h>
#include <tbb/global_control.h>

#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr float kHalfWidth = 3;  // voxels

openvdb::FloatGrid::Ptr meshGrid(const std::string& path, const openvdb::math::Transform& voxels) {
    std::ifstream file(path);
    std::string word;
    std::size_t points = 0, triangles = 0, edges = 0;
    if (!(file >> word >> points >> triangles >> edges) || word != "OFF") {
        throw std::runtime_error(path + ": cannot be read as .off; give a text file of triangles");
    }
    std::vector<openvdb::Vec3s> vertices(points);
    for (auto& vertex : vertices) file >> vertex[0] >> vertex[1] >> vertex[2];
    std::vector<openvdb::Vec3I> faces(triangles);
    for (auto& face : faces) {
        int corners = 0;
        file >> corners >> face[0] >> face[1] >> face[2];
        if (corners != 3) throw std::runtime_error(path + ": has faces other than triangles");
    }
    if (!file) throw std::runtime_error(path + ": ends early");
    return openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(voxels, vertices, faces, kHalfWidth);
}

void run(int argc, char** argv) {
    if (argc < 5 || argc > 7) {
        throw std::runtime_error(
            "usage: fill_with_spheres box:SIDE|MESH.off LOW HIGH OUT.csv [VOXEL [INSTANCES]]");
    }
    const std::string domain = argv[1];
    const float low = std::stof(argv[2]), high = std::stof(argv[3]);
    const float voxel = argc > 5 ? std::stof(argv[5]) : low / 4;
    const int instances = argc > 6 ? std::stoi(argv[6]) : 100000;

    openvdb::initialize();
    const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
    const auto voxels = openvdb::math::Transform::createLinearTransform(voxel);
    openvdb::FloatGrid::Ptr grid;
    if (domain.rfind("box:", 0) == 0) {
        const float half = std::stof(domain.substr(4)) / 2;
        const openvdb::math::BBox<openvdb::Vec3s> box(openvdb::Vec3s(-half), openvdb::Vec3s(half));
        grid = openvdb::tools::createLevelSetBox<openvdb::FloatGrid>(box, *voxels, kHalfWidth);
    } else {
        grid = meshGrid(domain, *voxels);
    }

    // There can be no more spheres than instances, so the larger of both numbers is scattered.
    std::vector<openvdb::Vec4s> spheres;
    openvdb::tools::fillWithSpheres(*grid, spheres, /*sphereCount=*/{0, instances},
                                    /*overlapping=*/false, low / voxel, high / voxel,
                                    /*isovalue=*/0.0f, instances);

    std::FILE* file = std::fopen(argv[4], "w");
    if (!file) throw std::runtime_error(std::string(argv[4]) + ": cannot be written");
    std::fputs("x,y,z,radius\n", file);
    for (const auto& s : spheres) {
        std::fprintf(file, "%.9g,%.9g,%.9g,%.9g\n", s[0], s[1], s[2], s[3]);
    }
    if (std::fclose(file) != 0) throw std::runtime_error(std::string(argv[4]) + ": disk full?");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "fill_with_spheres: %s\n", error.what());
        return 1;
    }
}
