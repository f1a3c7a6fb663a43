#include "vdbpack/formats/output_target.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/image/label_map.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <vector>

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
    {"contacts:", OutputKind::contacts, ".csv", ""},
    {"bonds:", OutputKind::bonds, ".csv", ""},
    {"bond-coeffs:", OutputKind::bondCoefficients, ".lmp", ""},
    {"interfaces:", OutputKind::interfaces, ".csv", ""},
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

const Prefix* prefixOf(const std::string& output) {
    const auto* const p =
        std::find_if(std::begin(kPrefixes), std::end(kPrefixes),
                     [&](const Prefix& each) { return startsWith(output, each.text); });
    return p == std::end(kPrefixes) ? nullptr : p;
}

/// Refuses what looks like a prefix, but for a letter or two.
void refuseMisspelt(const std::string& output) {
    const auto colon = output.find(':');
    if (colon == std::string::npos || output.find('/') < colon || packPath(output) != output)
        return;
    std::vector<std::string> words = packPrefixes();
    for (const Prefix& p : kPrefixes) words.emplace_back(p.text);
    const std::string alike = similarWord(output.substr(0, colon + 1), words);
    if (!alike.empty())
        throw ParameterError(output + ": its prefix is none of a format" + alike +
                             " A file of this name is written as ./" + output);
}

}  // namespace

OutputTarget::OutputTarget(const std::string& output) : text(output), file(packPath(output)) {
    if (const Prefix* const p = prefixOf(output)) {
        kind = p->kind;
        file = filePart(output);
        grid = p->grid;
        labels = p->labels;
        if (file.empty())
            throw ParameterError(output + ": names a format but no file; write " + output + "FILE" +
                                 (p->extension ? p->extension : ".csv"));
        if (p->extension && extension() != p->extension)
            throw ParameterError(fmt::format("{}: is written as {} alone; name it {}FILE{}", output,
                                             p->extension, p->text, p->extension));
        if (kind == OutputKind::labels && !namesLabelMap(file))
            throw ParameterError(fmt::format(
                "{}: label maps are written as .nii, .nii.gz, .nrrd or .mha; name it {}FILE.nii.gz",
                output, p->text));
        return;
    }
    refuseMisspelt(output);
    if (extensionOf(output) == ".stl") {
        kind = OutputKind::contour;
        file = output;
    }
}

std::string OutputTarget::extension() const {
    return extensionOf(file);
}

bool OutputTarget::isSolid() const {
    switch (kind) {
        case OutputKind::contour:
        case OutputKind::levelSets:
        case OutputKind::fog:
            return true;
        case OutputKind::pack:
            return file == text && extension() == ".vdb";
        default:
            return false;
    }
}

bool OutputTarget::listsBonds() const {
    return isOfBonds() || startsWith(text, "lammps-bonds:");
}

bool OutputTarget::listsPairs() const {
    return kind == OutputKind::contacts || kind == OutputKind::interfaces || listsBonds();
}

std::string filePart(const std::string& name) {
    const Prefix* const p = prefixOf(name);
    return p ? name.substr(std::string(p->text).size()) : packPath(name);
}

std::string interruptedName(const std::string& name) {
    const std::string file = filePart(name);
    std::string extension = std::filesystem::path(file).extension().string();
    if (extension == ".gz")  // .nii.gz
        extension = std::filesystem::path(file).stem().extension().string() + extension;
    const std::string mark = ".interrupted";
    // A name of more than 255 bytes is cut, between characters.
    const std::size_t bytes = std::filesystem::path(file).filename().string().size() + mark.size();
    std::size_t stem = name.size() - extension.size();
    if (bytes > 255) {
        stem -= std::min(bytes - 255, stem);
        while (stem > 0 && (static_cast<unsigned char>(name[stem]) & 0xc0) == 0x80) --stem;
    }
    return name.substr(0, stem) + mark + extension;
}

}  // namespace vdbpack
