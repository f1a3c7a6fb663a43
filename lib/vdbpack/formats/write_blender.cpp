#include "vdbpack/formats/write_blender.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>
#include <string_view>
#include <type_traits>

namespace vdbpack {

extern const char* const kBlenderScene;

namespace {

/// The line of the script that is replaced by the facts about the pack.
constexpr const char* kPackLine = "PACK = {}  # filled in by the writer\n";
constexpr std::size_t kRowsAtOnce = 1 << 14;

/// A field of the records: its numpy type, and a function that appends the value of a sphere.
struct Field {
    std::string name;
    std::string type;
    std::function<void(std::string&, std::size_t)> append;
};

template <typename T, typename Get>
Field field(std::string_view name, const Get& get) {
    return {std::string(name),
            fmt::format("<{}{}", std::is_floating_point_v<T> ? 'f' : 'i', sizeof(T)),
            [get](std::string& bytes, std::size_t i) {
                appendLittleEndian(bytes, static_cast<T>(get(i)));
            }};
}

/// Whether a name is a plain word, safe between quotes and in Blender's nodes.
bool isPlainName(std::string_view name) {
    return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_';
    });
}

std::vector<Field> fieldsOf(const PackView& pack, const std::array<double, 3>& center) {
    std::vector<Field> fields;
    const char* const axes[] = {"x", "y", "z"};
    for (std::size_t d = 0; d < 3; ++d)
        fields.push_back(field<float>(
            axes[d], [&pack, d, c = center[d]](std::size_t i) { return pack.position(i)[d] - c; }));
    fields.push_back(field<float>("radius", [&pack](std::size_t i) { return pack.radius(i); }));
    fields.push_back(field<std::int64_t>("id", [&pack](std::size_t i) { return pack.id(i); }));
    std::set<std::string, std::less<>> used;
    for (const Field& f : fields) used.insert(f.name);
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            if (isPlainName(name) && used.emplace(name).second)
                fields.push_back(field<ValueOf<decltype(numbers)>>(
                    name, [&pack, &numbers](std::size_t i) { return pack.value(numbers, i); }));
        },
        [](std::string_view, const auto&) {});  // Blender has no attributes of texts
    return fields;
}

/// Writes an array of records as numpy.save would. @return the CRC-32 of the records.
std::uint32_t writeRecords(const PackView& pack, const std::vector<Field>& fields,
                           OutputFile& out) {
    std::string dtype;
    for (const Field& f : fields) dtype += fmt::format("('{}', '{}'), ", f.name, f.type);
    std::string header = fmt::format("{{'descr': [{}], 'fortran_order': False, 'shape': ({},), }}",
                                     dtype.substr(0, dtype.size() - 2), pack.size());
    // Version 2.0 has 32 bits for the length of the header; the records start at a multiple of 64.
    constexpr std::size_t kFront = 12;
    header.append(63 - (kFront + header.size()) % 64, ' ');
    header += '\n';
    std::string bytes("\x93NUMPY\x02\x00", 8);
    appendLittleEndian(bytes, static_cast<std::uint32_t>(header.size()));
    out.write(bytes + header);

    uLong crc = crc32(0, nullptr, 0);
    for (std::size_t first = 0; first < pack.size(); first += kRowsAtOnce) {
        bytes.clear();
        const std::size_t end = std::min(pack.size(), first + kRowsAtOnce);
        for (std::size_t i = first; i < end; ++i)
            for (const Field& f : fields) f.append(bytes, i);
        crc = crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()),
                    static_cast<uInt>(bytes.size()));
        out.write(bytes);
    }
    return static_cast<std::uint32_t>(crc);
}

std::array<double, 3> middleOf(const PackView& pack) {
    std::array<double, 3> low{}, high{};
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < pack.size(); ++i) {
        const auto p = pack.position(i);
        for (std::size_t d = 0; d < 3; ++d) {
            low[d] = std::min(low[d], p[d]);
            high[d] = std::max(high[d], p[d]);
        }
    }
    std::array<double, 3> middle{};
    if (pack.size() > 0)
        for (std::size_t d = 0; d < 3; ++d) middle[d] = 0.5 * (low[d] + high[d]);
    return middle;
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
    std::vector<std::string> files = {script, stem + ".points.npy"};
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
    const std::array<double, 3> center = middleOf(view);

    OutputFile points(files[1]);
    const std::uint32_t crc = writeRecords(view, fieldsOf(view, center), points);

    std::string known = "PACK = {\n";
    const auto add = [&known](const char* key, const std::string& value) {
        known += fmt::format("    \"{}\": {},\n", key, value);
    };
    add("name", pythonLiteral(nameOf(script), script));
    add("points", pythonLiteral(nameOf(files[1]), script));
    // "" where there is no level set to show.
    std::string seen;
    if (levelSets) seen = volume.empty() ? nameOf(files[2]) : relativePath(script, volume);
    add("volume", pythonLiteral(seen, script));
    add("count", std::to_string(view.size()));
    add("crc32", std::to_string(crc));
    add("dim", std::to_string(Dim));
    add("unit", pythonLiteral(unitName(options.unit), script));
    std::string place = "[";
    for (const double c : center) {
        if (place.size() > 1) place += ", ";
        appendNumber(place, c);
    }
    add("center", place + "]");
    add("generator", pythonLiteral(options.generator, script));
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
