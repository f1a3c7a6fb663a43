// Options about runs: what is read and written, threads, memory, reports, pictures.
#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/option_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

namespace vdbpack {

const char* const kPackHelp =
    ".vdb (point grid), .csv, .txt, .dat, .vtp, .vtu, .vtk, .hdf, .pvtp, .pvtu, .ply, .xyz, .npz, "
    "YADE text (yade:FILE.txt), LAMMPS or LIGGGHTS data or dump (.data, .dump, lammps:FILE, "
    "dump:FILE), MercuryDPM .restart, GenGeo .geo; from any program";

PackColumns parsePackColumns(const std::string& text) {
    PackColumns columns;
    for (const std::string& item : splitAt(text, ',')) {
        const auto sign = item.find('=');
        if (sign == item.npos)
            columns.inOrder.push_back(item);
        else
            columns.renamed.emplace_back(trimmed(item.substr(0, sign)),
                                         trimmed(item.substr(sign + 1)));
        if (item.empty() || sign == 0 || sign + 1 == item.size() ||
            (!columns.inOrder.empty() && !columns.renamed.empty()))
            throw ParameterError("`packColumns` '" + text +
                                 "': write the names of all columns, such as x,y,z,r, or new names "
                                 "of some, such as x=East,y=North,z=Up,r=size");
    }
    return columns;
}

namespace {

const char* const kOutputHelp =
    "file to write; may be repeated. Packs: .vdb .vtp .hdf .pvtp .ply .csv .xyz .npz .usda .usdz, "
    ".data or lammps:FILE or liggghts:FILE, lammps-bonds:FILE (pairs in contact as bonds), "
    "yade:FILE.txt, spherepack:FILE.txt, points:FILE.vdb (no level sets), .svg (circles). Solids: "
    ".stl "
    "(surface:FILE.stl, voids:FILE.stl or solid:FILE.stl selects one), levelsets:FILE.vdb, "
    "fog:FILE.vdb. blender:FILE.py: a script that shows the spheres. Lists: contacts:FILE.csv "
    "(pairs in contact), bonds:FILE.csv (these as elastic bonds), bond-coeffs:FILE.lmp (their "
    "stiffness for LAMMPS), interfaces:FILE.csv (of parts), materials:FILE.csv, "
    "list:FILE.csv (voids). Label maps (.nii .nii.gz .nrrd "
    ".mha): labels:FILE (ids + 1 of spheres), labels-regions:, labels-parts:, labels-materials:, "
    "labels-solid:FILE (the domain or solid)";

/// More gain nothing anywhere, and each takes memory.
constexpr std::uint64_t kMostThreads = 4096;

const Names<PreviewColor> kColors{{"radius", PreviewColor::radius},
                                  {"region", PreviewColor::region},
                                  {"depth", PreviewColor::depth},
                                  {"order", PreviewColor::order}};

std::string textOf(const PackColumns& columns) {
    std::string text;
    for (const std::string& name : columns.inOrder) text += (text.empty() ? "" : ",") + name;
    for (const auto& [name, from] : columns.renamed)
        text += (text.empty() ? "" : ",") + name + "=" + from;
    return text;
}

void setColor(PreviewOptions& preview, const std::string& name) {
    if (name.empty()) throw ParameterError("`preview.color`: must not be empty");
    const auto known = std::find_if(kColors.begin(), kColors.end(),
                                    [&](const auto& color) { return color.first == name; });
    preview.color = known == kColors.end() ? PreviewColor::column : known->second;
    preview.column = known == kColors.end() ? name : "";
}

}  // namespace

std::vector<std::uint64_t> parseSeeds(const std::string& text) {
    constexpr std::uint64_t kMostSeeds = 1'000'000;
    const auto fail = [&](const char* why) {
        throw ParameterError(
            fmt::format("`seed` '{}': {}; write a whole number from 0 on, a range 1..50 or a list "
                        "1,4,9",
                        text, why));
    };
    const auto number = [&](const std::string& word) {
        std::uint64_t value = 0;
        const char* const end = word.data() + word.size();
        const auto [stop, failed] = std::from_chars(word.data(), end, value);
        if (failed != std::errc() || stop != end) fail("is no seed");
        return value;
    };
    std::vector<std::uint64_t> seeds;
    for (const std::string& item : splitAt(text, ',')) {
        const auto dots = item.find("..");
        const std::uint64_t first = number(item.substr(0, dots));
        const std::uint64_t last = dots == item.npos ? first : number(item.substr(dots + 2));
        if (last < first) fail("the range ends before it begins");
        if (last - first >= kMostSeeds || seeds.size() + (last - first) >= kMostSeeds)
            fail("has more than a million seeds");
        for (std::uint64_t i = 0; i <= last - first; ++i) seeds.push_back(first + i);
    }
    auto sorted = seeds;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
        fail("names a seed twice");
    return seeds;
}

void packReadingOptions(OptionList& rows, Unit& unit, PackColumns& columns, double& radius,
                        const char* pack) {
    const std::string of = pack;
    unitOption(rows, "pack-unit", unit, ("unit of " + of + ", if its file states none").c_str());
    rows.group("Units");
    rows.custom(
            "columns", "NAMES",
            "names for the columns of " + of +
                " where its file has none, or unknown ones: of all columns in order, such as "
                "x,y,z,r,material, or of some, such as x=East,diameter=size; a unit may follow: "
                "radius_um",
            [&columns](const std::string& text) { columns = parsePackColumns(text); },
            [&columns] { return textOf(columns); })
        .as("columns packColumns");
    rows.length("pack-radius", "R", radius, Range::positive,
                "radius of all spheres of " + of + ", if its file has no radii, mm")
        .as("packRadius");
}

void packArgument(OptionList& rows, InputPack& input, const char* name, const std::string& help) {
    rows.group("");
    rows.text(name, "", input.pack, help).naming(FileIn::pack).required = true;
}

void inputPackOptions(OptionList& rows, InputPack& input, const char* name, const std::string& help,
                      const char* domainShown) {
    packArgument(rows, input, name, help);
    domainOption(rows, input.domain, {}, domainShown);
    domainOptions(rows, input.domain);
    packReadingOptions(rows, input.packUnit, input.packColumns, input.packRadius, "the pack");
    sizeOptions(rows, input.radius, input.weightBy, "; the radii of the pack are compared with it");
    contactTolerance(rows, input.contactTolerance);
    threadsOption(rows, input);
    memoryLimit(rows, input);
}

void outputOption(OptionList& rows, std::vector<OutputTarget>& outputs, const char* help) {
    rows.group("Output");
    Option& output =
        rows.custom("output", "FILE", help ? help : kOutputHelp,
                    [&outputs](const std::string& text) { outputs.emplace_back(text); });
    output.repeats = true;
    output.as("outputs").naming(FileIn::output).offPage().letter = "o";
}

void imagesOption(OptionList& rows, bool& images) {
    rows.group("Output");
    rows.flag("images", images,
              "of a periodic cell, write the images that protrude into it, too, with the column "
              "image_of; files for YADE and LAMMPS never hold them");
}

void contactTolerance(OptionList& rows, double& tolerance) {
    rows.group("Run");
    rows.number("contact-tol", "T [0.001]", tolerance, Range::notNegative,
                "two spheres are in contact if their gap is at most T times the smaller radius")
        .as("contactTolerance");
}

void threadsOption(OptionList& rows, RunSettings& settings, const char* help) {
    rows.group("Run");
    rows.count("threads", "T [all cores]", settings.threads, 1, kMostThreads, help,
               "leave it out to use all cores")
        .passing()
        .offPage();
}

void memoryLimit(OptionList& rows, RunSettings& settings) {
    rows.group("Run");
    rows.custom("memory-limit", "SIZE [free memory]",
                "memory that the run may use: 8G, 500M, 1.5GiB. A run predicted to exceed it is "
                "refused, a run that exceeds it stops (exit code 5)",
                [&settings](const std::string& text) {
                    const auto size = parseBytes(text);
                    if (!size)
                        throw ParameterError("`memoryLimit` '" + text +
                                             "': not a size of memory. Write a positive number of "
                                             "bytes, or one with a unit: 8G, 500M, 1.5GiB");
                    settings.memoryLimit = *size;
                })
        .of(OptionKind::numbers)
        .passing();
}

void reportOption(OptionList& rows, RunSettings& settings, const char* help) {
    rows.group("Run");
    rows.text("report", "FILE.json|FILE.html", settings.reportFile,
              help ? help : "write the report as JSON, or as a page for the browser")
        .as("reportFile")
        .naming(FileIn::whole)
        .offPage();
}

void printing(OptionList& rows, PrintOptions& print, const char* json) {
    rows.group("Run");
    rows.flag("json", print.json, json ? json : "print the report as JSON instead of the summary")
        .passing();
    rows.flag("quiet", print.quiet, "print warnings and errors only").passing();
}

void seedOption(OptionList& rows, RunSettings& settings, const char* random) {
    rows.group("Run");
    rows.count("seed", "S [1]", settings.seed, 0, std::numeric_limits<std::uint64_t>::max(),
               std::string("seed of the random numbers: ") + random)
        .offPage();
}

void studyOptions(OptionList& rows, Study& study, const std::string& made) {
    rows.group("Run");
    rows.custom("seed", "S [1]",
                "seed of the random numbers; a range 1..50 or a list 1,4,9 makes one " + made +
                    " for each seed in one domain ({seed} in names of outputs)",
                [&study](const std::string& text) { study.seeds = parseSeeds(text); })
        .of(OptionKind::count);
    rows.text(
            "table", "FILE.csv", study.table,
            "write a table with one row for each run; options that are numbers may then be lists, "
            "such as `target-bvtv` 0.15,0.25: a run for each combination ({target-bvtv} in "
            "names of outputs)")
        .naming(FileIn::whole)
        .passing();
}

void cutAndColor(OptionList& rows, PreviewOptions& preview) {
    rows.group("Run");
    rows.custom("preview-cut", "x=V|y=V|z=V",
                "cut picture and view open at a plane, mm; what lies farther from the camera "
                "remains: lower x, lower z, higher y",
                [&preview](const std::string& text) { preview.cut = parsePreviewCut(text); })
        .as("preview.cut");
    rows.custom("preview-color", "NAME",
                "color of the spheres by radius, region, depth, order or a column of numbers: from "
                "dark (small, outside, early) to light; without it by part, where a pack has two "
                "to eight, else by radius",
                [&preview](const std::string& name) { setColor(preview, name); })
        .as("preview.color");
}

void previewOptions(OptionList& rows, PreviewOptions& preview) {
    rows.group("Run");
    rows.text("preview", "FILE.png", preview.file,
              "write a picture of the result; a report page contains it too")
        .as("preview.file")
        .naming(FileIn::whole)
        .offPage();
    cutAndColor(rows, preview);
    rows.custom("preview-view", "SIDE|X,Y,Z",
                "side from which the picture is seen: front, back, left or right of the patient, "
                "top, bottom, or the direction X,Y,Z; a cut keeps what is farther away",
                [&preview](const std::string& text) { preview.view = parsePreviewView(text); })
        .as("preview.view")
        .of(OptionKind::numbers);
    rows.custom("preview-size", "WxH|N [1600]",
                "width and height in pixels, or the longer side of a picture fitted to the bone",
                [&preview](const std::string& text) {
                    const auto size = parsePreviewSize(text);
                    preview.width = size[0];
                    preview.height = size[1];
                })
        .as("preview.width preview.height");
}

}  // namespace vdbpack
