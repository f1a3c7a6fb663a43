// Which options each command has, and what is known of all of them.
#include "vdbpack/io/text.h"
#include "vdbpack/options/jobs.h"
#include "vdbpack/options/option_rows.h"

#include <algorithm>
#include <map>
#include <string_view>

namespace vdbpack {

namespace {

/// Number of points that are searched in about an hour.
constexpr std::uint64_t kMostVacancySamples = 10'000'000'000;
const char* const kOutUnitHelp = "unit of what is written";
const char* const kResultAsJson = "print the result as JSON";
const char* const kSolidHelp =
    "; or a solid: a mesh (.stl .obj .off .ply .gts .vtk), an image (with `label` or `threshold`; "
    "A,B and all are several), a level set (.vdb) or a shape";
const char* const kRequiredDomain = "DOMAIN (required without a cell in PACK)";
const Names<Fill> kFills{{"domain", Fill::domain}, {"solid", Fill::solid}};

const Names<PartsBy> kPartsBy{
    {"group", PartsBy::group}, {"component", PartsBy::component}, {"center", PartsBy::center}};

void partsOption(OptionList& rows, std::string& file, PartsBy& by, const char* help) {
    rows.group("Domain");
    rows.text("parts", "FILE.toml", file, help).as("partsFile").naming(FileIn::whole);
    rows.choice("parts-by", "group|component|center", by, kPartsBy,
                "group, component: several parts of the mesh of the domain, which are the solids "
                "of an ASCII .stl or the groups (g, o) of an .obj, or its connected components; "
                "center: one pack over several labels of an image (`label` A,B or all), without "
                "walls between them, each sphere in the label at its center")
        .as("partsBy")
        .excludes = "parts";
}

void list(OptionList& rows, PackJob& job, PrintOptions& print) {
    domainArgument(rows, job.domain);
    outputOption(rows, job.outputs);
    domainOptions(rows, job.domain);
    partsOption(rows, job.partsFile, job.domain.partsBy,
                "pack several domains, each a table [[part]] of a TOML file: name, domain, and "
                "options by their names. Where they overlap, the later one has the space");
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    imagesOption(rows, job.images);
    sphereOptions(rows, job);
    densityOption(rows, job.density);
    greyOptions(rows, job.grey);
    bondOptions(rows, job.bonds);
    voidOptions(rows, job.request, job.domain, VoidsIn::pack);
    rows.choice("fill", "domain|solid [domain]", job.request.fill, kFills,
                "domain: fill the domain, then remove the spheres in voids; solid: cut the voids "
                "first, then fill what they leave");
    studyOptions(rows, job.study, "pack");
    threadsOption(rows, job, "number of threads (of each process); the pack does not depend on it");
    deviceOption(rows, job.densify.device);
    memoryLimit(rows, job);
    rows.flag("dry-run", job.dryRun,
              "predict count, solid fraction, time, memory and sizes of files; write nothing")
        .passing();
    contactTolerance(rows, job.contactTolerance);
    reportOption(rows, job,
                 "write the report: .json for programs, .html as a page with charts for the "
                 "browser (with the values of measure)");
    previewOptions(rows, job.preview);
    printing(rows, print);
}

void list(OptionList& rows, VoidsJob& job, PrintOptions& print) {
    domainArgument(rows, job.domain);
    outputOption(rows, job.outputs,
                 "file to write; may be repeated: .vdb (level sets surface, voids, solid), .stl "
                 "(of solid; surface:FILE.stl or voids:FILE.stl selects another), fog:FILE.vdb, "
                 "list:FILE.csv (voids)");
    domainOptions(rows, job.domain);
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    voidOptions(rows, job.request, job.domain, VoidsIn::nothing);
    studyOptions(rows, job.study, "set of voids");
    reportOption(rows, job);
    printing(rows, print);
    previewOptions(rows, job.preview);
    threadsOption(rows, job);
    memoryLimit(rows, job);
}

void list(OptionList& rows, CarveJob& job, PrintOptions& print) {
    inputPackOptions(rows, job, "PACK", kPackHelp, kRequiredDomain);
    outputOption(rows, job.outputs);
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    densityOption(rows, job.density);
    greyOptions(rows, job.grey);
    voidOptions(rows, job.request, job.domain, VoidsIn::file);
    seedOption(rows, job, "of the voids");
    reportOption(rows, job);
    printing(rows, print);
    previewOptions(rows, job.preview);
}

void list(OptionList& rows, DensifyRecipe& job, PrintOptions& print) {
    inputPackOptions(rows, job, "PACK", kPackHelp, kRequiredDomain);
    outputOption(rows, job.outputs);
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    imagesOption(rows, job.images);
    densityOption(rows, job.density);
    greyOptions(rows, job.grey);
    densifyOption(rows, job.densify.fraction,
                  "add and move spheres until the solid fraction is F, or as high as possible "
                  "(max); without this option, no sphere is added and only overlaps are removed");
    gapOption(rows, job.densify.gap,
              "least distance between spheres, and between spheres and the wall, mm");
    deviceOption(rows, job.densify.device);
    seedOption(rows, job,
               "of the radii and positions of added spheres, and of exchanges between spheres");
    reportOption(rows, job);
    printing(rows, print);
    previewOptions(rows, job.preview);
}

void list(OptionList& rows, VerifyRecipe& job, PrintOptions& print) {
    inputPackOptions(rows, job, "PACK", kPackHelp);
    partsOption(rows, job.partsFile, job.domain.partsBy,
                "the parts that the pack was made with: each sphere is held against its own");
    gapOption(rows, job.gap, "least distance required between spheres, mm");
    rows.group("Run");
    rows.count("places", "N", job.vacancySamples, 1, kMostVacancySamples,
               "search N points of the domain for vacancies that have room for a sphere of 1.02 "
               "mean radii")
        .as("vacancySamples");
    rows.flag("json", print.json, kResultAsJson).passing();
}

void list(OptionList& rows, MeasureRecipe& job, PrintOptions& print) {
    inputPackOptions(
        rows, job, "FILE",
        std::string("a pack: ") + kPackHelp +
            "; or a solid: a level set (.vdb), a mesh (.stl .obj .off .ply .gts .vtk) or "
            "an image (with `label` or `threshold`)");
    outputOption(rows, job.outputs, "contacts:FILE.csv: the pairs in contact");
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    rows.group("Domain");
    rows.length("shell", "T", job.shell, Range::notNegative,
                "measure the layer of this thickness along the wall separately, mm");
    shellFromOption(rows, job.domain);
    rows.group("Spheres");
    rows.flag("morphometry", job.sphereMorphometry,
              "of a pack: measure the union of its spheres as a solid, too")
        .as("sphereMorphometry");
    rows.length("dilation", "D [5 % of the mean radius]", job.dilation, Range::notNegative,
                "added to the radii for `morphometry`, mm, so that contacts become necks");
    reportOption(rows, job,
                 "write all values: .json for programs, .html as a page with charts for the "
                 "browser");
    rows.flag("json", print.json, "print all values as JSON").passing();
}

void list(OptionList& rows, StiffnessRecipe& job, PrintOptions& print) {
    inputPackOptions(rows, job, "PACK", kPackHelp);
    outputOption(rows, job.outputs,
                 "bonds:FILE.csv, contacts:FILE.csv: the pairs; bond-coeffs:FILE.lmp: their "
                 "stiffness for LAMMPS");
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    bondOptions(rows, job.bonds);
    rows.custom("bond-modulus-for", "E,NU|E",
                "find modulus and shear ratio of the bonds with which this pack has an apparent "
                "Young's modulus E, MPa, and Poisson's ratio NU (of the isotropic average); with "
                "`press`, the modulus with which it has E between its grips",
                [&job](const std::string& text) {
                    std::tie(job.wantedModulus, job.wantedPoisson) = parseModulusAndPoisson(text);
                    job.fits = true;
                })
        .of(OptionKind::numbers);
    rows.length("boundary", "T [0.1 mean radius]", job.boundary, Range::notNegative,
                "spheres up to so far from the wall of the domain move as the strain has it, mm");
    rows.custom(
        "press", "x|y|z",
        "press the body between two rigid grips along an axis, sides free, instead of straining "
        "its wall: its apparent modulus by the mean cross-section of the domain",
        [&job](const std::string& text) {
            const auto at = std::string("xyz").find(text);
            if (text.size() != 1 || at == std::string::npos)
                throw ParameterError("`press` " + text + ": write x, y or z");
            job.press = static_cast<int>(at);
        },
        [&job] { return job.press ? std::string(1, "xyz"[*job.press]) : std::string(); });
    rows.length(
        "grip", "L", job.grip, Range::positive,
        "depth of a grip of `press`, mm: it holds the spheres whose centers lie in it "
        "(default: four mean radii, or deeper until these cover 80 % of the cross-section)");
    rows.group("Run");
    rows.flag("json", print.json, kResultAsJson).passing();
}

void list(OptionList& rows, ConvertRecipe& job, PrintOptions& print) {
    packArgument(rows, job, "PACK",
                 std::string("a pack: ") + kPackHelp + kSolidHelp +
                     ". With several labels, {part} in the name of an output becomes the name of "
                     "each");
    outputOption(rows, job.outputs);
    packReadingOptions(rows, job.packUnit, job.packColumns, job.packRadius, "PACK");
    unitOption(rows, "out-unit", job.outUnit, kOutUnitHelp);
    imagesOption(rows, job.images);
    domainOption(rows, job.domain,
                 "domain whose level set or surface can be written too, and to which `density` "
                 "bulk:D refers: ");
    domainOptions(rows, job.domain, &job.packGrid);
    contactTolerance(rows, job.contactTolerance);
    densityOption(rows, job.density);
    greyOptions(rows, job.grey);
    bondOptions(rows, job.bonds);
    previewOptions(rows, job.preview);
    threadsOption(rows, job);
    memoryLimit(rows, job);
    printing(rows, print, kResultAsJson);
}

/// The options of commands that report on the file of a domain.
void fileOptions(OptionList& rows, RunSettings& settings, DomainRecipe& domain,
                 PrintOptions& print) {
    threadsOption(rows, settings);
    unitOption(rows, "unit", domain.unit, "unit of the file");
    rows.number("scale", "F [1]", domain.scale, Range::any, "further factor on its lengths");
    memoryLimit(rows, settings);
    printing(rows, print);
}

void list(OptionList& rows, MeshRecipe& job, PrintOptions& print) {
    rows.text("FILE", "", job.domain.source, "mesh (.stl .obj .ply .off .gts .vtp .vtk)")
        .naming(FileIn::pack)
        .required = true;
    outputOption(
        rows, job.outputs,
        "write the mesh as .stl, repaired with `repair`, and moved with `transform` and the like");
    rows.group("Run");
    rows.flag("check", job.check,
              "exit with code 1 if the mesh cannot be packed as it is; with `repair`, if it cannot "
              "be packed once repaired");
    poseOptions(rows, job.domain.pose);
    repairOptions(rows, job.domain);
    fileOptions(rows, job, job.domain, print);
}

void list(OptionList& rows, ImageRecipe& job, PrintOptions& print) {
    rows.text("FILE", "", job.domain.source,
              "image (.nii .nii.gz .nrrd .nhdr .mha .mhd), or a folder of DICOM or TIFF files or "
              "of masks")
        .naming(FileIn::pack)
        .required = true;
    thresholdOption(rows, job.domain);
    imagePlacement(rows, job.domain);
    fileOptions(rows, job, job.domain, print);
}

void list(OptionList& rows, ViewJob& job, PrintOptions& print) {
    packArgument(rows, job, "PACK", std::string(kPackHelp) + kSolidHelp);
    rows.group("Output");
    Option& page = rows.text("output", "FILE.html [NAME.view.html]", job.reportFile,
                             "page to write: one file that needs no other, and no network");
    page.as("outputs reportFile").naming(FileIn::output).letter = "o";
    rows.custom("no-open", "", "do not open the page; without a display, it is not opened anyway",
                [&job](const std::string&) { job.opens = false; })
        .kind = OptionKind::flag;
    cutAndColor(rows, job.preview);
    packReadingOptions(rows, job.packUnit, job.packColumns, job.packRadius, "PACK");
    domainOption(rows, job.domain, "domain whose wall is shown around the spheres: ");
    domainOptions(rows, job.domain);
    threadsOption(rows, job);
    memoryLimit(rows, job);
    printing(rows, print);
}

/// The rows of all commands with defaults, and the jobs that they are bound to.
struct AllCommands {
    std::vector<CommandText> commands = commandTexts();
    PrintOptions print;
    std::vector<Option> rows;
    std::map<std::string, std::string, std::less<>> optionOfField;

    AllCommands() {
        for (CommandText& command : commands)
            for (Option& row : optionsOf(command.job, print)) {
                for (const std::string& field : splitAt(row.fields, ' '))
                    optionOfField.emplace(field, row.name);
                rows.push_back(std::move(row));
            }
        for (const Option& row : rows) optionOfField.emplace(row.name, row.name);
    }
};

const AllCommands& allCommands() {
    static const AllCommands all;
    return all;
}

}  // namespace

const std::vector<CommandText>& commandTexts() {
    static const std::vector<CommandText> texts{
        {"pack", "fill a domain with spheres (2D: circles)", PackJob()},
        {"voids", "make voids and the remaining solid, without spheres", VoidsJob()},
        {"carve", "cut voids into an input pack", CarveJob()},
        {"densify", "make an input pack denser, or remove its overlaps; radii do not change",
         DensifyRecipe()},
        {"verify",
         "check a pack of any program for overlaps and protrusions, with code independent of the "
         "packer",
         VerifyRecipe()},
        {"measure",
         "measure density, contacts, sizes and structure of any pack; morphometry of a level set, "
         "a mesh or an image",
         MeasureRecipe()},
        {"stiffness", "compute the apparent stiffness of the bonded spheres of a pack",
         StiffnessRecipe()},
        {"convert",
         "convert packs, and the surfaces of meshes, images and level sets, to other formats",
         ConvertRecipe()},
        {"mesh", "report whether a mesh can be packed, and repair it", MeshRecipe()},
        {"image", "report what a label map or a CT contains, and where it lies", ImageRecipe()},
        {"view",
         "write a page that shows a pack or a solid, to turn, zoom and cut in a browser, and open "
         "it",
         ViewJob()},
    };
    return texts;
}

std::vector<Option> optionsOf(Job& job, PrintOptions& print) {
    OptionList rows;
    std::visit([&](auto& recipe) { list(rows, recipe, print); }, job);
    return rows.take();
}

FileIn fileIn(const std::string& option) {
    const auto& rows = allCommands().rows;
    const auto found = std::find_if(rows.begin(), rows.end(),
                                    [&](const Option& row) { return row.name == option; });
    return found == rows.end() ? FileIn::none : found->file;
}

std::string withOptionNames(const std::string& message, OptionStyle style) {
    const auto& names = allCommands().optionOfField;
    std::string text;
    std::size_t at = 0;
    for (;;) {
        const std::size_t open = message.find('`', at);
        const std::size_t close = open == std::string::npos ? open : message.find('`', open + 1);
        if (close == std::string::npos) return text + message.substr(at);
        text += message.substr(at, open - at);
        const auto known = names.find(std::string_view(message).substr(open + 1, close - open - 1));
        if (known == names.end()) {  // another use of backquotes
            text += '`';
            at = open + 1;
            continue;
        }
        text += style(known->second);
        at = close + 1;
    }
}

std::vector<std::pair<std::string, std::string>> givenOptions(Job job) {
    std::vector<std::pair<std::string, std::string>> given;
    PrintOptions print;
    Job usual = std::visit([](const auto& j) { return Job(std::decay_t<decltype(j)>()); }, job);
    const std::vector<Option> rows = optionsOf(job, print), defaults = optionsOf(usual, print);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Option& row = rows[i];
        if (!row.onPage || !row.get) continue;
        const auto values = row.get();
        if (values == defaults[i].get()) continue;
        for (const std::string& value : values)
            given.emplace_back(optionName(row.name),
                               value + (row.kind == OptionKind::length ? " mm" : ""));
    }
    return given;
}

}  // namespace vdbpack
