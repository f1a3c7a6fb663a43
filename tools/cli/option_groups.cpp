#include "cli/option_groups.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

using namespace vdbpack;

const char* const kDomainHelp =
    "mesh (.stl .obj .ply .off .vtp .vtk), image (.nii .nii.gz .nrrd .nhdr .mha .mhd, folder of "
    "DICOM "
    "or TIFF files), level set (.vdb) or shape about the origin: "
    "box:LX,LY,LZ  "
    "box:x0,y0,z0,x1,y1,z1  ball:R  cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  disc:R  "
    "periodic:LX,LY,LZ  periodic:LX,LY";
/// What -o of runs with spheres takes.
const char* const kOutputHelp =
    "file to write; may be repeated. Packs: .vdb .vtp .hdf .pvtp .ply .csv .xyz .npz .usda .usdz, "
    ".data or lammps:FILE or "
    "liggghts:FILE, lammps-bonds:FILE (pairs in contact as bonds), yade:FILE.txt, points:FILE.vdb "
    "(no level sets), .svg (circles). Solids: .stl (surface:FILE.stl, voids:FILE.stl or "
    "solid:FILE.stl selects one), levelsets:FILE.vdb, fog:FILE.vdb. blender:FILE.py: a script that "
    "shows the spheres. Lists: contacts:FILE.csv (pairs in contact), materials:FILE.csv, "
    "list:FILE.csv (voids). Label maps (.nii .nii.gz .nrrd .mha): labels:FILE (ids + 1 of "
    "spheres), "
    "labels-regions:, labels-parts:, labels-materials:, labels-solid:FILE (the domain or solid)";

const char* const kReportHelp = "write the report as JSON, or as a page for the browser";

const char* const kPackHelp =
    ".vdb (point grid), .csv, .vtp, .hdf, .pvtp, .ply, .xyz, .npz, YADE text (yade:FILE.txt), "
    "LAMMPS or LIGGGHTS data or dump (.data, .dump, lammps:FILE, dump:FILE); from any program";

namespace {

constexpr std::int64_t kMostDensityClasses = 1000;

const Names<Unit> kUnits{{"m", Unit::meter},
                         {"cm", Unit::centimeter},
                         {"mm", Unit::millimeter},
                         {"um", Unit::micrometer}};
const Names<WeightBy> kWeights{{"count", WeightBy::count}, {"volume", WeightBy::volume}};

const Names<PreviewColor> kPreviewColors{{"radius", PreviewColor::radius},
                                         {"region", PreviewColor::region},
                                         {"depth", PreviewColor::depth},
                                         {"order", PreviewColor::order}};

const Names<Cull> kCulls{
    {"centre", Cull::center}, {"center", Cull::center}, {"touch", Cull::touch}};

const Names<RepairComponents> kRepairComponents{{"together", RepairComponents::together},
                                                {"separate", RepairComponents::separate}};

const Names<ImageSpace> kSpaces{{"lps", ImageSpace::lps}, {"ras", ImageSpace::ras}};
const Names<ShellFrom> kShellFrom{{"walls", ShellFrom::walls}, {"outer", ShellFrom::outer}};

/// More gain nothing anywhere, and each takes memory.
constexpr std::uint64_t kMostThreads = 4096;

const std::string kRadiusSpec =
    "constant:R | uniform:A,B | normal:MEAN,SD,A,B | lognormal:MEDIAN,SIGMA,A,B | table:FILE | "
    "psd:FILE";

/// The number that a whole text is; not a number for any other text.
double numberOf(const std::string& text) {
    double value = 0;
    return parseReal(text, value) ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

CLI::Validator positive() {
    return CLI::Validator(
        [](const std::string& text) {
            const double value = numberOf(text);
            return value > 0 && std::isfinite(value) ? std::string()
                                                     : "'" + text + "' must be a positive number";
        },
        "");
}

CLI::Validator notNegative() {
    return CLI::Validator(
        [](const std::string& text) {
            const double value = numberOf(text);
            return value >= 0 && std::isfinite(value)
                       ? std::string()
                       : "'" + text + "' must be a number of 0 or more";
        },
        "");
}

CLI::Validator wholeNumber(std::uint64_t least, std::uint64_t most, const std::string& remedy) {
    return CLI::Validator(
        [least, most, remedy](std::string& text) {
            std::uint64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto [stop, failed] = std::from_chars(text.data(), end, value);
            bool whole = failed == std::errc() && stop == end;
            // 1e6 is one, too, as far as doubles are exact.
            if (const double number = numberOf(text);
                !whole && failed != std::errc::result_out_of_range && number >= 0 &&
                number <= 0x1p53 && number == std::floor(number)) {
                value = static_cast<std::uint64_t>(number);
                text = std::to_string(value);
                whole = true;
            }
            if (whole && value >= least && value <= most) return std::string();
            return "'" + text + "' must be a whole number from " + std::to_string(least) + " to " +
                   std::to_string(most) + (remedy.empty() ? "" : "; " + remedy);
        },
        "");
}

CLI::Validator notEmpty() {
    return CLI::Validator(
        [](const std::string& text) {
            return text.empty() ? std::string("must not be empty") : std::string();
        },
        "");
}

void addUnit(CLI::App& command, const std::string& option, Unit& unit, const std::string& help) {
    addChoice(command, option, unit, kUnits, help)->option_text("UNIT [mm]")->group("Units");
}

void addOutputs(CLI::App& command, std::vector<std::string>& outputs, const std::string& help) {
    command.add_option("-o,--output", outputs, help)
        ->option_text("FILE")
        ->take_all()
        ->group("Output");
}

void addContactTolerance(CLI::App& command, double& tolerance) {
    command
        .add_option("--contact-tol", tolerance,
                    "two spheres are in contact if their gap is at most T times the smaller radius")
        ->option_text("T [0.001]")
        ->check(notNegative())
        ->group("Run");
}

void addImages(CLI::App& command, bool& images) {
    command
        .add_flag(
            "--images", images,
            "of a periodic cell, write the images that protrude into it, too, with the column "
            "image_of; files for YADE and LAMMPS never hold them")
        ->group("Output");
}

void addGap(CLI::App& command, double& gap) {
    command
        .add_option("--gap", gap,
                    "least distance between spheres, and between spheres and the wall, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
}

void addDensify(CLI::App& command, double& fraction, const std::string& help) {
    command
        .add_option_function<std::string>(
            "--densify", [&fraction](const std::string& text) { fraction = parseDensify(text); },
            help)
        ->option_text("F|max")
        ->group("Spheres");
}

void addThreads(CLI::App& command, int& threads, const std::string& help) {
    command.add_option("--threads", threads, help)
        ->option_text("T [all cores]")
        ->transform(wholeNumber(1, kMostThreads, "leave it out to use all cores"))
        ->group("Run");
}

void addMemoryLimit(CLI::App& command, double& bytes) {
    command
        .add_option_function<std::string>(
            "--memory-limit",
            [&bytes](const std::string& text) {
                const auto size = parseBytes(text);
                if (!size)
                    throw ParameterError("--memory-limit '" + text +
                                         "': not a size of memory. Write a positive number of "
                                         "bytes, or one with a unit: 8G, 500M, 1.5GiB");
                bytes = *size;
            },
            "memory that the run may use: 8G, 500M, 1.5GiB. A run predicted to exceed it is "
            "refused, a run that exceeds it stops (exit code 5)")
        ->option_text("SIZE [free memory]")
        ->group("Run");
}

void addDomainOptions(CLI::App& command, DomainRecipe& domain) {
    addUnit(command, "--unit", domain.unit, "unit of the domain's file: m, cm, mm or um");
    command.add_option("--scale", domain.scale, "further factor on the file's lengths")
        ->option_text("F [1]")
        ->group("Units");
    command
        .add_option("--grid", domain.gridName,
                    "level set, or with --threshold fog volume, to take from a .vdb")
        ->option_text("NAME [first]")
        ->group("Domain");
    addImageOptions(command, domain);
    command
        .add_option("--slice", domain.slice,
                    "use the plane z = V of the domain; its spheres are circles")
        ->option_text("z=V")
        ->group("Domain")
        ->expected(1);
    command
        .add_option("--clip", domain.clips,
                    "keep only a part of the domain: box:x0,y0,z0,x1,y1,z1 or plane:nx,ny,nz,d "
                    "(where n.x <= d); may be repeated")
        ->option_text("CLIP")
        ->group("Domain")
        ->take_all();
    command
        .add_option("--periodic", domain.periodic,
                    "axes along which a box or rectangle repeats, such as xy: it has no walls "
                    "there. periodic:LX,LY,LZ repeats along all")
        ->option_text("AXES")
        ->check(notEmpty())
        ->group("Domain")
        ->expected(1);
    command.add_option("--voxel", domain.voxelSize, "voxel size of the distance field, mm")
        ->option_text("H [automatic]")
        ->check(positive())
        ->group("Domain");
    addRepairOptions(command, domain);
}

void addImageOptions(CLI::App& command, DomainRecipe& domain) {
    command
        .add_option("--threshold", domain.threshold,
                    "take an image, or a fog volume of a .vdb, as the domain where its values are "
                    "at least V")
        ->option_text("V")
        ->group("Domain");
    command
        .add_option("--label", domain.label,
                    "label of an image to fill, by value or name; A+B joins two to one domain. "
                    "With pack and "
                    "verify, A,B and all are several parts, each with its own surface")
        ->option_text("L")
        ->check(notEmpty())
        ->group("Domain");
    addImagePlacement(command, domain);
}

void addImagePlacement(CLI::App& command, DomainRecipe& domain) {
    command
        .add_option(
            "--voxel-spacing", domain.voxelSpacing,
            "distances of voxels, mm: of an image whose files state none, such as TIFF; else "
            "of the label maps that are written (-o labels:FILE)")
        ->option_text("X,Y,Z|D")
        ->check(notEmpty())
        ->group("Domain");
    addChoice(command, "--space", domain.space, kSpaces,
              "axes of the world of images: lps (x to the left, y to the back, as in DICOM) or ras "
              "(x to the right, y to the front, as in NIfTI)")
        ->option_text("lps|ras [lps]")
        ->group("Domain");
}

void addRepairOptions(CLI::App& command, DomainRecipe& domain) {
    command
        .add_flag("--repair", domain.repair,
                  "repair a mesh that has holes, inverted or duplicate triangles, or overlapping "
                  "or loose components; -o FILE.stl writes the repaired mesh")
        ->group("Domain");
    command
        .add_option(
            "--repair-voxel", domain.repairVoxel,
            "voxel size where --repair remeshes the surface, mm; smaller voxels keep thinner walls")
        ->option_text("H [automatic]")
        ->check(positive())
        ->group("Domain");
    addChoice(
        command, "--repair-components", domain.repairComponents, kRepairComponents,
        "how --repair treats the surface components of the mesh. separate: each by itself, so "
        "that bones in one file stay apart unless they intersect; together: the inside is that "
        "of all triangles")
        ->option_text("together|separate [together]")
        ->group("Domain");
    auto* cavities =
        command
            .add_option("--cavities", domain.cavities,
                        "closed surface components inside others: keep leaves the cavities in them "
                        "empty, fill fills them. inner=FILE removes the inside of a second mesh "
                        "from DOMAIN; outer=FILE,inner=FILE replaces DOMAIN")
            ->option_text("keep|fill|[outer=FILE,]inner=FILE [keep]")
            ->group("Domain");
    // The name and the words of former recipes.
    command
        .add_option_function<std::string>(
            "--shells",
            [&domain](const std::string& text) {
                domain.cavities = text == "cavity" ? "keep" : text == "solid" ? "fill" : text;
            },
            "--cavities")
        ->excludes(cavities)
        ->group("");
}

void addShellFrom(CLI::App& command, DomainRecipe& domain, const std::string& group) {
    addChoice(command, "--shell-from", domain.shellFrom, kShellFrom,
              "what --shell is measured from. walls: all walls; outer: the outer surface alone, "
              "not the walls of cavities nor the planes of --clip")
        ->option_text("walls|outer [walls]")
        ->group(group);
}

void addSizeOptions(CLI::App& command, std::string& radius, WeightBy& weightBy,
                    const std::string& note) {
    command.add_option("--radius", radius, kRadiusSpec + ", in mm" + note)
        ->option_text("SPEC")
        ->check(notEmpty())
        ->group("Spheres");
    addChoice(
        command, "--weight-by", weightBy, kWeights,
        "whether the weights of table:FILE are shares of the number or of the volume of spheres")
        ->option_text("count|volume [count]")
        ->group("Spheres");
}

void addGreyOptions(CLI::App& command, GreyRecipe& grey) {
    command
        .add_option("--sample", grey.samples,
                    "add a column: the mean of an image, such as a CT, over each sphere; may be "
                    "repeated")
        ->option_text("NAME=IMAGE")
        ->group("Grey values")
        ->take_all();
    auto* calibrate =
        command
            .add_option(
                "--calibrate", grey.calibration,
                "density of each sphere, SLOPE * grey value + INTERCEPT, kg/m3 (= mg/cm3), as "
                "column density_kg_m3 and in the files of LAMMPS and LIGGGHTS; of --sample, or "
                "of the column NAME")
            ->option_text("[NAME=]SLOPE,INTERCEPT")
            ->check(notEmpty())
            ->group("Grey values");
    command
        .add_option("--modulus", grey.modulus,
                    "Young's modulus of each sphere, A * density^B, MPa, of the density in g/cm3, "
                    "as column modulus_MPa; E alone: the same for all. Parts may have their own")
        ->option_text("A,B|E")
        ->check(notEmpty())
        ->group("Grey values");
    command
        .add_option("--density-classes", grey.classes,
                    "classes of equal width that the densities fall into: materials of YADE and "
                    "types of LAMMPS, listed by materials:FILE.csv")
        ->option_text("N [10]")
        ->transform(wholeNumber(1, kMostDensityClasses))
        ->needs(calibrate)
        ->group("Grey values");
}

void addDensityOption(CLI::App& command, std::string& density) {
    command
        .add_option(
            "--density", density,
            "density of the spheres in the files of LAMMPS and LIGGGHTS, kg/m3; 0=D,1=D: by "
            "region; bulk:D: all spheres together weigh as much as the domain at density D")
        ->option_text("D|0=D,1=D|bulk:D [1000]")
        ->check(notEmpty())
        ->group("Spheres");
}

void addInputPack(CLI::App& command, InputPack& input, const char* name, const std::string& help) {
    command.add_option(name, input.pack, help)->required();
    command.add_option("--domain", input.domain.source, kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    addDomainOptions(command, input.domain);
    addUnit(command, "--pack-unit", input.packUnit,
            "unit of " + std::string(name) + ", if the file states none");
    addSizeOptions(command, input.radius, input.weightBy,
                   "; the radii of the pack are compared with it");
    addContactTolerance(command, input.contactTolerance);
    addThreads(command, input.threads, "number of threads");
    addMemoryLimit(command, input.memoryLimit);
}

void addReport(CLI::App& command, std::string& file, const std::string& help) {
    command.add_option("--report", file, help)->option_text("FILE.json|FILE.html")->group("Run");
}

void addPrinting(CLI::App& command, PrintOptions& print) {
    command.add_flag("--json", print.json, "print the report as JSON instead of the summary")
        ->group("Run");
    command.add_flag("--quiet", print.quiet, "print warnings and errors only")->group("Run");
}

void addRunOptions(CLI::App& command, std::uint64_t& seed, std::string& report, PrintOptions& print,
                   const std::string& random) {
    command.add_option("--seed", seed, "seed of the random numbers: " + random)
        ->option_text("S [1]")
        ->transform(wholeNumber(0, std::numeric_limits<std::uint64_t>::max()))
        ->group("Run");
    addReport(command, report, kReportHelp);
    addPrinting(command, print);
}

void addCutAndColor(CLI::App& command, PreviewRecipe& preview) {
    command
        .add_option_function<std::string>(
            "--preview-cut", [&](const std::string& text) { preview.cut = parsePreviewCut(text); },
            "cut picture and view open at a plane, mm; what lies farther from the camera remains: "
            "lower x, lower z, higher y")
        ->option_text("x=V|y=V|z=V")
        ->group("Run");
    command
        .add_option_function<std::string>(
            "--preview-color",
            [&](const std::string& name) {
                const auto known =
                    std::find_if(kPreviewColors.begin(), kPreviewColors.end(),
                                 [&](const auto& color) { return color.first == name; });
                preview.color =
                    known == kPreviewColors.end() ? PreviewColor::column : known->second;
                preview.column = known == kPreviewColors.end() ? name : "";
            },
            "color of the spheres by radius, region, depth, order or a column of numbers such as "
            "part: from dark (small, outside, early) to light")
        ->option_text("NAME [radius]")
        ->check(notEmpty())
        ->group("Run");
}

void addPreviewOptions(CLI::App& command, PreviewRecipe& preview) {
    command
        .add_option("--preview", preview.file,
                    "write a picture of the result; a report page contains it too")
        ->option_text("FILE.png")
        ->check(notEmpty())
        ->group("Run");
    addCutAndColor(command, preview);
    command
        .add_option_function<std::string>(
            "--preview-size",
            [&](const std::string& text) {
                const auto size = parsePreviewSize(text);
                preview.width = size[0];
                preview.height = size[1];
            },
            "width and height in pixels")
        ->option_text("WxH [1600x1200]")
        ->group("Run");
}

namespace {

/// The options of voids, in the order of the help.
struct VoidOptions {
    CLI::App& command;
    VoidRecipe& voids;
    DomainRecipe& domain;
    bool front;    ///< spheres are packed, so that voids may be packed with them
    bool spheres;  ///< there are spheres to cut, packed or read

    template <class Value>
    CLI::Option* option(const char* name, Value& value, const std::string& help,
                        const std::string& text) const {
        return command.add_option(name, value, help)->option_text(text)->group("Voids");
    }
    static std::string orElse(bool first, const char* a, const char* b) { return first ? a : b; }

    void addMethod() const;
    void addTargets() const;
    void addShapes() const;
    void addDirections() const;
};

void VoidOptions::addMethod() const {
    option("--voids", voids.method,
           "how voids are made: grid, overlay, " + orElse(spheres, "concentric, threshold, ", "") +
               orElse(front, "mixed, ellipses, ", "") + "boolean, foam or list:FILE",
           "METHOD")
        ->check(notEmpty());
    std::vector<std::string> methods{"grid", "overlay", "boolean", "foam", "list:"};
    if (spheres) methods.insert(methods.end(), {"concentric", "threshold"});
    if (front) methods.insert(methods.end(), {"mixed", "ellipses"});
    setWords(*command.get_option("--voids"), methods);
    option("--shell", voids.shell,
           "thickness of the layer along the wall that stays without voids, mm" +
               orElse(spheres, "; without --voids it only sets the region of each sphere", ""),
           "T [0]")
        ->check(notNegative());
    option("--shell-field", voids.shellField,
           "the same by place, in place of --shell: a .csv (x, y, z, value) or a .vdb grid of "
           "floats, in mm",
           "FILE")
        ->check(notEmpty());
    addShellFrom(command, domain, "Voids");
    auto* cull = addChoice(command, "--cull", voids.cull, kCulls,
                           "spheres that voids remove. centre: those with centers in a void; "
                           "touch: all that reach into one")
                     ->option_text("centre|touch [centre]")
                     ->group("Voids");
    command
        .add_flag("--keep-connected", voids.keepConnected,
                  "remove what is not connected to the shell; without a shell, all but the largest "
                  "component")
        ->group("Voids");
    if (!spheres) cull->group("");  // accepted, without effect
}

void VoidOptions::addTargets() const {
    const std::string packed = front ? ", mixed, ellipses" : "";
    option("--target-bvtv", voids.targetBvtv,
           "BV/TV to reach in the part deeper than the shell. It sets the number of voids "
           "(boolean, overlay), their size (foam)" +
               orElse(spheres, ", the probability (grid", " or the probability (grid") + packed +
               ")" + orElse(spheres, " or D (concentric, threshold)", ""),
           "F");
    option(
        "--bvtv-field", voids.bvtvField,
        "BV/TV by place (boolean, foam): the grey values of an image such as a CT, a .vdb grid of "
        "floats, or a .csv (x, y, z, value), in mm; without --target-bvtv, its mean is the "
        "target",
        "FILE")
        ->check(notEmpty());
    option("--bvtv-range", voids.bvtvRange,
           "values of that field at BV/TV 0 (marrow) and 1 (bone), linear between them; needed for "
           "an image, 0,1 for others",
           "MARROW,BONE")
        ->check(notEmpty());
    option("--target-tbth", voids.targetTbth,
           "mean thickness Tb.Th of trabeculae to reach, mm (foam; boolean with --target-bvtv)",
           "T");
    option("--target-tbsp", voids.targetTbsp, "mean spacing Tb.Sp to reach, mm (foam)", "T");
    option("--target-da", voids.targetDa,
           "degree of anisotropy to reach, 1 - (short / long)² as measure prints it (foam)", "D");
    option("--target-connd", voids.targetConnd,
           "connectivity density Conn.D to reach, 1/mm³ (foam)", "C");
    option("--trabecular", voids.trabecular,
           "targets from published morphometry, for those that are not given (foam); list prints "
           "the names with their numbers and sources",
           "NAME|list")
        ->check(notEmpty())
        ->each([](const std::string& name) {
            if (name == "list") throw CLI::CallForVersion(presetTable(), 0);
        });
    option("--like", voids.like,
           "targets and main direction from a specimen: an image, a level set or a mesh (foam)",
           "SAMPLE")
        ->check(notEmpty());
    option("--like-domain", voids.likeDomain,
           "total volume of that specimen (all of an image, else the box around the solid)",
           "DOMAIN")
        ->check(notEmpty());
    option("--like-threshold", voids.likeThreshold,
           "of an image with grey values: those from this on are solid", "V");
    option("--void-voxel", voids.voxelSize, "voxel size of the level sets of voids, mm",
           "H [1/4 half-axis]")
        ->check(positive());
}

void VoidOptions::addShapes() const {
    const std::string written = spheres ? "written as --radius" : kRadiusSpec;
    option(
        "--void-radius", voids.radius,
        "shorter half-axis b of the voids, " + written + ", mm (" +
            orElse(front, "mixed: radius of the holes; ", "") +
            "overlay: voids are placed by packing spheres of radius b times aspect; foam: before "
            "they are dilated)",
        orElse(spheres, "SPEC [1.5 to 2.5 largest spheres]", "SPEC"))
        ->check(notEmpty());
    option("--void-aspect", voids.aspect,
           "ratio of the half-axes a / b, written as " +
               std::string(spheres ? "--radius" : "--void-radius"),
           "SPEC [constant:2; foam 1.4, without a direction 1]")
        ->check(notEmpty());
    option("--void-blend", voids.blend,
           "length over which voids run into one another, mm: rounds the edges between them, and "
           "opens walls that are thinner",
           "K [0; foam 0.1 of the mean b]");
    option("--void-jitter", voids.jitter,
           "foam: largest displacement of a void, in its radii, 0 to 1; 0 leaves walls with many "
           "small holes, 1 thick struts that may be loose",
           "J [0.25]");
    option("--void-strut", voids.strut,
           "thickness of the struts that remain between voids that overlap, along the lines where "
           "three of them (2D: two) are equally near, mm",
           "T [0; foam 0.2 of the mean b, 2D 0.08]");
    option("--void-strut-share", voids.strutShare, "share of these lines that have a strut, 0 to 1",
           "P [1]");
    option(
        "--void-count", voids.count,
        "number of voids. boolean: mean number with centers deeper than the shell; voids of the "
        "same density lie around that part. overlay: number taken of all that fit (default: all)",
        "N");
    option("--void-probability", voids.probability,
           "probability that a box contains a void (grid)" +
               orElse(front, ", that a sphere is a hole (mixed, ellipses)", ""),
           orElse(front, "P [grid 1, else 0.02]", "P [1]"));
    auto* share = option("--delete-fraction", voids.deleteFraction,
                         "D of method concentric: share of the spheres that is removed, in balls "
                         "of radius Rmin/D to Rmax/D around random spheres. D of method threshold: "
                         "spheres with radii above Rmax - D (Rmax - Rmin) are removed",
                         "D");
    option("--void-matrix", voids.matrix, "file with 0 or 1 for each box of grid, top row first",
           "FILE")
        ->check(notEmpty());
    option("--void-cell", voids.cell,
           "sides of a box of grid, mm: one value, or one for each direction (default: as many "
           "boxes as the matrix has)",
           "SIZE")
        ->check(notEmpty());
    if (!spheres) share->group("");  // accepted, without effect
}

void VoidOptions::addDirections() const {
    option("--void-angles", voids.orientation.angles,
           "directions of the long axes. \"tz=SPEC;tx=SPEC\": along z, rotated by tx about x, then "
           "by tz about z. \"phi=SPEC\" (2D): along x, rotated by phi. isotropic: no preferred "
           "direction. SPEC is V, uniform:A,B or normal:MEAN,SD,A,B, in rad or with suffix deg. "
           "With --void-axis or --void-field: scatter about that direction. Default without those: "
           "isotropic for boolean and foam, else within 0.358 rad of z (2D: of x)",
           "ANGLES")
        ->check(notEmpty());
    option("--void-axis", voids.orientation.axis, "direction of the long axes", "X,Y,Z")
        ->check(notEmpty());
    option("--void-field", voids.orientation.field,
           "direction of the long axes at each position: .vdb (vectors, or the main axis of a "
           "tensor) or .csv (x, y, z and a direction or six stress components), in mm",
           "FILE")
        ->check(notEmpty());
}

}  // namespace

void addVoidOptions(CLI::App& command, VoidRecipe& voids, DomainRecipe& domain, VoidsIn in) {
    const VoidOptions options{command, voids, domain, in == VoidsIn::pack, in != VoidsIn::nothing};
    options.addMethod();
    options.addTargets();
    options.addShapes();
    options.addDirections();
}
