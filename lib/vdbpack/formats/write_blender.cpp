#include "vdbpack/formats/write_blender.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/byte_order.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

namespace vdbpack {

extern const char* const kBlenderScene;

namespace {

/// The line of the script that is replaced by the facts about the pack.
constexpr const char* kPackLine = "PACK = {}  # filled in by the writer\n";

/// The CRC-32 of all positions, little-endian as in a file.
std::uint32_t crcOfPositions(const PackView& pack) {
    uLong crc = crc32(0, nullptr, 0);
    std::string bytes;
    for (std::size_t i = 0; i < pack.size(); ++i) {
        bytes.clear();
        for (const double c : pack.position(i)) appendLittleEndian(bytes, c);
        crc = crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()),
                    static_cast<uInt>(bytes.size()));
    }
    return static_cast<std::uint32_t>(crc);
}

/// A string literal of Python: the escapes of JSON mean the same there.
std::string pythonLiteral(const std::string& text, const std::string& file) {
    try {
        return nlohmann::json(text).dump();
    } catch (const nlohmann::json::exception&) {
        throw ParameterError(file +
                             ": the name is not UTF-8, which Python scripts are written in; "
                             "choose another one");
    }
}

std::string stemOf(const std::string& script) {
    const std::filesystem::path path(script);
    if (path.extension() != ".py" || path.stem().empty())
        throw ParameterError(script + ": is a Python script for Blender; name it blender:FILE.py");
    return script.substr(0, script.size() - 3);
}

std::string nameOf(const std::string& file) {
    return std::filesystem::path(file).filename().string();
}

/// The path of `volume` relative to the folder of `script`, so that both can be moved together.
std::string relativePath(const std::string& script, const std::string& volume) {
    namespace fs = std::filesystem;
    std::error_code failed;
    const fs::path from = fs::weakly_canonical(fs::absolute(script).parent_path(), failed);
    const fs::path to = fs::weakly_canonical(fs::absolute(volume).parent_path(), failed);
    const fs::path way = fs::relative(to, from, failed);
    const fs::path name = fs::path(volume).filename();
    if (failed || way.empty()) return fs::absolute(volume).string();
    return (way / name).lexically_normal().string();
}

}  // namespace

std::vector<std::string> blenderFiles(const std::string& script, bool levelSets,
                                      const std::string& volume) {
    const std::string stem = stemOf(script);
    std::vector<std::string> files = {script, stem + ".points.npz"};
    if (levelSets && volume.empty()) files.push_back(stem + ".vdb");
    return files;
}

template <int Dim>
std::vector<std::string> writeBlender(const Pack<Dim>& pack, const std::string& script,
                                      const PackWriteOptions& options, const std::string& volume) {
    const bool levelSets = !options.levelSets.empty();
    const auto files = blenderFiles(script, levelSets, volume);
    checkPack(pack);
    const PackView view(pack, options.unit);
    OutputFile points(files[1]);
    writeNpz(view, options, points);

    // "" where there is no level set to show.
    std::string seen;
    if (levelSets) seen = volume.empty() ? nameOf(files[2]) : relativePath(script, volume);
    const std::vector<std::pair<const char*, std::string>> facts{
        {"name", pythonLiteral(nameOf(script), script)},
        {"points", pythonLiteral(nameOf(files[1]), script)},
        {"volume", pythonLiteral(seen, script)},
        {"count", std::to_string(view.size())},
        {"crc32", std::to_string(crcOfPositions(view))},
        {"dim", std::to_string(Dim)},
        {"unit", pythonLiteral(unitName(options.unit), script)},
        {"generator", pythonLiteral(options.generator, script)}};
    std::string known = "PACK = {\n";
    for (const auto& [key, value] : facts) known += fmt::format("    \"{}\": {},\n", key, value);
    known += "}\n";
    std::string text = kBlenderScene;
    const auto at = text.find(kPackLine);
    if (at == std::string::npos) throw Error("blender_scene.py: has no line for the pack");
    text.replace(at, std::string(kPackLine).size(), known);
    OutputFile out(script);
    out.write(text);

    // The script comes last: it names the others and holds the checksum of its points.
    if (levelSets && volume.empty()) writeLevelSets(files[2], options);
    points.commit();
    out.commit();
    return files;
}

template std::vector<std::string> writeBlender<2>(const Pack<2>&, const std::string&,
                                                  const PackWriteOptions&, const std::string&);
template std::vector<std::string> writeBlender<3>(const Pack<3>&, const std::string&,
                                                  const PackWriteOptions&, const std::string&);

}  // namespace vdbpack
