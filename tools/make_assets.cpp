// Makes the bundled meshes; every run gives the same files, byte for byte.

#include "assets/catalog.h"
#include "assets/surfacing.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/output_file.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

constexpr const char* kUsage =
    "usage: make_assets [--check] [--mesh NAME] FOLDER\n"
    "Writes the bundled meshes (femur, mandible, hip, skull, irregular) to FOLDER as .ply files.\n"
    "  --check      write nothing; exit 1 if a file differs from what would be written\n"
    "  --mesh NAME  this one only; may be repeated\n";

std::string contentOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw vdbpack::IoError(path + ": cannot be opened; make it with make_assets FOLDER");
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
    for (const std::string& n : names)
        if (n == name) return true;
    return false;
}

int run(const std::vector<std::string>& arguments) {
    bool check = false;
    std::string folder;
    std::vector<std::string> wanted;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        if (arguments[i] == "--check")
            check = true;
        else if (arguments[i] == "--mesh" && i + 1 < arguments.size())
            wanted.push_back(arguments[++i]);
        else if (folder.empty() && arguments[i].substr(0, 1) != "-")
            folder = arguments[i];
        else
            throw vdbpack::ParameterError(
                fmt::format("unexpected argument '{}'\n{}", arguments[i], kUsage));
    }
    if (folder.empty()) throw vdbpack::ParameterError(std::string("no FOLDER given\n") + kUsage);
    for (const std::string& name : wanted) {
        bool known = false;
        for (const vdbpack::Asset& asset : vdbpack::assets()) known = known || asset.name == name;
        if (!known) throw vdbpack::ParameterError(fmt::format("no mesh '{}'\n{}", name, kUsage));
    }

    int failures = 0;
    fmt::print("{:<10}{:>10}{:>10}{:>7}{:>11}{:>11}  {}\n", "mesh", "triangles", "vertices",
               "Euler", "cm3", "cm2", "size, mm");
    for (const vdbpack::Asset& asset : vdbpack::assets()) {
        if (!wanted.empty() && !contains(wanted, asset.name)) continue;
        const auto start = std::chrono::steady_clock::now();
        const vdbpack::TriangleMesh mesh = vdbpack::surfaceOf(asset.sculpt(), asset.voxelSize);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        const vdbpack::SurfaceCheck c = vdbpack::checkSurface(mesh);
        const vdbpack::Vec<3> size = mesh.bounds().size();
        fmt::print(
            "{:<10}{:>10}{:>10}{:>7}{:>11.2f}{:>11.2f}  {:.1f} x {:.1f} x {:.1f}  ({:.1f} s)\n",
            asset.name, c.triangles, c.vertices, c.eulerNumber, c.volume / 1e3, c.area / 1e2,
            size[0], size[1], size[2], seconds.count());
        if (!c.sound() || c.eulerNumber != asset.eulerNumber)
            throw vdbpack::InputError(fmt::format(
                "{}: not the surface expected: {} bad edges, {} bad vertices, {} slivers, {} "
                "pieces, Euler number {} instead of {}; change the sculpture or its voxel size",
                asset.name, c.badEdges, c.badVertices, c.slivers, c.pieces, c.eulerNumber,
                asset.eulerNumber));
        const std::string bytes = vdbpack::plyBytes(mesh, asset.what);
        const std::string path = folder + "/" + asset.name + ".ply";
        if (!check) {
            vdbpack::OutputFile file(path);
            file.write(bytes);
            file.commit();
        } else if (contentOf(path) != bytes) {
            fmt::print(stderr, "{}: differs from what make_assets makes; run it and commit\n",
                       path);
            ++failures;
        }
    }
    return failures > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(std::vector<std::string>(argv + 1, argv + argc));
    } catch (const vdbpack::ParameterError& e) {
        fmt::print(stderr, "make_assets: {}\n", e.what());
        return 2;
    } catch (const vdbpack::IoError& e) {
        fmt::print(stderr, "make_assets: {}\n", e.what());
        return 4;
    } catch (const std::exception& e) {
        fmt::print(stderr, "make_assets: {}\n", e.what());
        return 3;
    }
}
