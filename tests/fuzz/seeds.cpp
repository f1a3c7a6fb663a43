// Small files of ours to start the fuzzer from, where they are not text: seeds FOLDER writes
// FOLDER/FAMILY/*.
#include "vdbpack/core/rng.h"
#include "vdbpack/formats/pack_file.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

using namespace vdbpack;

namespace {

Pack<3> smallPack() {
    Pack<3> pack;
    RandomStream random(1, 1);
    for (int i = 0; i < 3; ++i) {
        Sphere<3> s;
        for (double& c : s.center.c)
            c = 8 + std::nearbyint(8 * random.uniform() * 0x1p10) * 0x1p-10;
        s.radius = 0.5;
        pack.spheres.push_back(s);
        pack.region.push_back(i % 2);
        pack.depth.push_back(0.25f * static_cast<float>(i));
    }
    pack.columns.push_back({"name", {}, {"left", "right", ""}});
    pack.columns.push_back({"weight", {0.5, -1, 1e30}, {}});
    return pack;
}

void writeStl(const std::string& path) {
    std::string bytes(80, ' ');
    const auto put = [&bytes](auto value) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        bytes.append(raw, sizeof value);
    };
    put(std::uint32_t{2});
    for (int t = 0; t < 2; ++t) {
        for (int i = 0; i < 12; ++i) put(static_cast<float>(i * (t + 1) % 5));
        put(std::uint16_t{0});
    }
    std::ofstream(path, std::ios::binary) << bytes;
}

void writeGrids(const std::string& folder) {
    using namespace openvdb;
    initialize();
    const auto ball = FloatGrid::create(1.5f);
    ball->setName("surface");
    ball->setGridClass(GRID_LEVEL_SET);
    ball->setTransform(math::Transform::createLinearTransform(0.5));
    auto values = ball->getAccessor();
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) {
                const float d = std::sqrt(static_cast<float>((x - 4) * (x - 4) + (y - 4) * (y - 4) +
                                                             (z - 4) * (z - 4))) -
                                2;
                if (std::fabs(d) < 3) values.setValue(Coord(x, y, z), 0.5f * d);
            }
    const auto axes = Vec3SGrid::create();
    axes->setName("axes");
    axes->tree().setValue(Coord(1, 2, 3), Vec3s(1, 0, 0));
    axes->tree().setValue(Coord(1, 2, 9), Vec3s(0, 1, 1));
    const auto save = [&folder](const std::string& name, const GridPtrVec& grids, bool half,
                                std::uint32_t compression) {
        for (const auto& grid : grids) grid->setSaveFloatAsHalf(half);
        io::File file(folder + "/" + name);
        file.setCompression(compression);
        file.write(grids);
    };
    save("ball.vdb", {ball}, false, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);
    save("ball_half.vdb", {ball}, true, io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
    save("axes.vdb", {axes}, false, io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
    save("both.vdb", {ball, axes}, false, io::COMPRESS_BLOSC);
    std::ofstream stream(folder + "/stream.vdb", std::ios::binary);
    io::Stream(stream).write(GridCPtrVec{ball});
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const auto folder = [&](const char* family) {
        const std::string path = std::string(argv[1]) + "/" + family;
        std::filesystem::create_directories(path);
        return path;
    };
    const Pack<3> pack = smallPack();
    for (const std::string family : {"vtp", "ply", "npz", "vdb"})
        writePack(pack, folder(family.c_str()) + "/pack." + family, {});
    writeStl(folder("mesh") + "/binary.stl");
    writeGrids(folder("vdb"));
    return 0;
}
