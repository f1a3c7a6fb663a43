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

/// Small images of the formats whose headers are checked before a library sees them.
void writeImages(const std::string& folder) {
    const auto save = [&folder](const std::string& name, const std::string& bytes) {
        std::ofstream(folder + "/" + name, std::ios::binary) << bytes;
    };
    const auto raw = [](auto value) {
        return std::string(reinterpret_cast<const char*>(&value), sizeof value);
    };
    std::string nifti = raw(std::int32_t{348}) + std::string(344, '\0') + std::string(4 + 8, '\0');
    const std::int16_t dims[] = {3, 2, 2, 2}, type = 2;
    nifti.replace(40, 8, reinterpret_cast<const char*>(dims), 8);
    nifti.replace(70, 2, raw(type));
    nifti.replace(108, 4, raw(352.0f));
    nifti.replace(344, 3, "n+1");
    save("a.nii", nifti);

    std::string tiff = "II*" + std::string(1, '\0') + raw(std::uint32_t{8});
    tiff += raw(std::uint16_t{1}) + raw(std::uint16_t{256}) + raw(std::uint16_t{3}) +
            raw(std::uint32_t{1}) + raw(std::uint32_t{2}) + raw(std::uint32_t{0});
    save("a.tif", tiff);

    const auto element = [&](std::uint16_t group, std::uint16_t number, const std::string& vr,
                             const std::string& value) {
        const bool wide = vr == "OW" || vr == "SQ";
        const auto size = static_cast<std::uint32_t>(value.size());
        return raw(group) + raw(number) + vr +
               (wide ? raw(std::uint16_t{0}) + raw(size) : raw(static_cast<std::uint16_t>(size))) +
               value;
    };
    const auto us = [&](int value) { return raw(static_cast<std::uint16_t>(value)); };
    save("a.dcm", std::string(128, '\0') + "DICM" + element(2, 0x10, "UI", "1.2.840.10008.1.2.1 ") +
                      element(8, 0x1140, "SQ",
                              raw(std::uint32_t{0xe000fffe}) + raw(std::uint32_t{10}) +
                                  element(8, 0x60, "CS", "CT")) +
                      element(0x20, 0x32, "DS", "0\\0\\1.5 ") + element(0x28, 2, "US", us(1)) +
                      element(0x28, 0x10, "US", us(2)) + element(0x28, 0x11, "US", us(2)) +
                      element(0x28, 0x100, "US", us(16)) + element(0x28, 0x101, "US", us(12)) +
                      element(0x28, 0x102, "US", us(11)) + element(0x7fe0, 0x10, "OW", "12345678"));
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
    writeImages(folder("image"));
    return 0;
}
