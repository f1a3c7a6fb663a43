#include "vdbpack/formats/output_target.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/image/label_map.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

namespace vdbpack {

namespace {

struct Prefix {
    const char* text;
    OutputKind kind;
    const char* extension;  ///< that its files have; null: any
    const char* grid;       ///< level set that it names; empty: the one left, of several
    const char* labels = "";
};
constexpr Prefix kPrefixes[] = {
    {"contacts:", OutputKind::contacts, nullptr, ""},
    {"list:", OutputKind::voidList, nullptr, ""},
    {"materials:", OutputKind::materials, ".csv", ""},
    {"surface:", OutputKind::contour, ".stl", kSurface},
    {"voids:", OutputKind::contour, ".stl", kVoids},
    {"solid:", OutputKind::contour, ".stl", kSolid},
    {"levelsets:", OutputKind::levelSets, ".vdb", ""},
    {"fog:", OutputKind::fog, ".vdb", ""},
    {"blender:", OutputKind::blender, ".py", ""},
    {"labels:", OutputKind::labels, nullptr, "", "ids"},
    {"labels-regions:", OutputKind::labels, nullptr, "", "regions"},
    {"labels-parts:", OutputKind::labels, nullptr, "", "parts"},
    {"labels-materials:", OutputKind::labels, nullptr, "", "materials"},
    {"labels-solid:", OutputKind::labels, nullptr, "", "solid"},
};

}  // namespace

OutputTarget targetOf(const std::string& output) {
    for (const Prefix& p : kPrefixes) {
        if (output.rfind(p.text, 0) != 0) continue;
        const std::string file = output.substr(std::string(p.text).size());
        if (file.empty())
            throw ParameterError(output + ": names a format but no file; write " + output + "FILE" +
                                 (p.extension ? p.extension : ".csv"));
        if (p.extension && extensionOf(file) != p.extension)
            throw ParameterError(fmt::format("{}: is written as {} alone; name it {}FILE{}", output,
                                             p.extension, p.text, p.extension));
        if (p.kind == OutputKind::labels && !namesLabelMap(file))
            throw ParameterError(fmt::format(
                "{}: label maps are written as .nii, .nii.gz, .nrrd or .mha; name it {}FILE.nii.gz",
                output, p.text));
        return {p.kind, file, p.grid, p.labels};
    }
    if (extensionOf(output) == ".stl") return {OutputKind::contour, output, "", ""};
    return {OutputKind::pack, packPath(output), "", ""};
}

std::string filePart(const std::string& name) {
    return targetOf(name).file;
}

}  // namespace vdbpack
