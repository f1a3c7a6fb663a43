#include "vdbpack/formats/pack_target.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"

#include <optional>

namespace vdbpack {

namespace {

/// Whether packs are written in a format: by its function, or in pieces, or by HDF5.
template <class Format>
bool isWritten(const Format& known) {
    return known.write != nullptr || known.format == PackFormat::pvtp ||
           known.format == PackFormat::vtkhdf;
}

/// "use .vdb, .vtp, ...": the formats that are written or read, for messages.
std::string formatList(bool written) {
    std::string list = "use ";
    for (const FormatName& known : kFormatNames)
        if (known.format != PackFormat::svg && (written ? isWritten(known) : known.read != nullptr))
            list += (known.extension ? "." + std::string(known.name)
                                     : known.name + std::string(":FILE")) +
                    ", ";
    return written ? list + ".svg for circles" : list.substr(0, list.size() - 2);
}

/// What runs write beside packs.
constexpr const char* kFurther =
    ", .stl, levelsets: or fog:FILE.vdb for surfaces, blender:FILE.py, contacts:, bonds:, "
    "interfaces:, materials: or list:FILE.csv, labels:FILE.nii.gz";

/// @param name  without the dot of an extension.
const FormatName* formatNamed(const std::string& name) {
    for (const auto& known : kFormatNames)
        if (lowered(name) == known.name) return &known;
    return nullptr;
}

/// The format named by the prefix and the file after it, if there is such a prefix.
std::optional<PackTarget> prefixed(const std::string& file) {
    const auto colon = file.find(':');
    if (colon == std::string::npos) return std::nullopt;
    const auto* known = formatNamed(file.substr(0, colon));
    if (known == nullptr) return std::nullopt;
    if (colon + 1 == file.size())
        throw ParameterError(file + ": names a format but no file; write " + file + "FILE");
    return PackTarget{known->format, file.substr(colon + 1), known->write, known->read};
}

/// By prefix, else by extension.
std::optional<PackTarget> knownTarget(const std::string& file) {
    if (auto known = prefixed(file)) return known;
    const auto* known = formatNamed(extensionOf(file).erase(0, 1));
    if (known == nullptr || !known->extension) return std::nullopt;
    return PackTarget{known->format, file, known->write, known->read};
}

/// Why a file is refused. @param written  whether to list formats that are written
std::string unknownFormat(const std::string& file, bool written) {
    if (extensionOf(file) == ".toml" && !written) requireThere(file);
    if (extensionOf(file) == ".toml")
        return file + ": holds options (`config`) or parts (`parts`) and no spheres; give the pack";
    std::vector<std::string> extensions;
    for (const auto& known : kFormatNames)
        if (known.extension) extensions.push_back(std::string(".") + known.name);
    return file + ": '" + extensionOf(file) + "' is not a pack format" +
           similarWord(extensionOf(file), extensions) + "; " + formatList(written);
}

/// The same as `knownTarget`; refuses unknown formats.
PackTarget target(const std::string& file, bool written) {
    if (auto known = knownTarget(file)) return *std::move(known);
    throw ParameterError(unknownFormat(file, written));
}

}  // namespace

std::vector<std::string> packPrefixes() {
    std::vector<std::string> prefixes;
    for (const FormatName& known : kFormatNames)
        if (!known.extension) prefixes.push_back(known.name + std::string(":"));
    return prefixes;
}

PackTarget targetToWrite(const std::string& file, int dim) {
    PackTarget t = target(file, true);
    if (!isWritten(t))
        throw ParameterError(file +
                             ": this format is read but not written (programs without a loader "
                             "read .csv, and bonds from bonds:FILE.csv); " +
                             formatList(true));
    if (t.format == PackFormat::svg && dim == 3)
        throw ParameterError(
            file + ": is a picture of circles; for spheres write .vtp or .vdb, or set `slice` z=V");
    return t;
}

PackTarget targetToRead(const std::string& file) {
    PackTarget t = target(file, false);
    if (t.read == nullptr)
        throw ParameterError(
            file +
            ": this format is written but not read; write the pack as .vtp or .csv beside it, or "
            "export the spheres as one of these from the program that made the file. To read a "
            "pack, " +
            formatList(false));
    return t;
}

std::string packPath(const std::string& file) {
    const auto known = prefixed(file);
    return known ? known->path : file;
}

bool holdsSurface(const std::string& file) {
    const auto known = knownTarget(file);
    return known && (known->format == PackFormat::usd || known->format == PackFormat::usdz);
}

bool holdsMasses(const std::string& file) {
    const auto known = knownTarget(file);
    return known &&
           (known->format == PackFormat::lammpsData || known->format == PackFormat::lammpsBonds);
}

void checkPackFormat(const std::string& file, int dim) {
    if (!knownTarget(file)) throw ParameterError(unknownFormat(file, true) + kFurther);
    targetToWrite(file, dim);
}

}  // namespace vdbpack
