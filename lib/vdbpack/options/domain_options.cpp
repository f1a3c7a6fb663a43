// Options about what is filled, and about the files that it comes from.
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/options/option_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace vdbpack {

const char* const kDomainHelp =
    "mesh (.stl .obj .ply .off .gts .vtp .vtk), image (.nii .nii.gz .nrrd .nhdr .mha .mhd, folder "
    "of DICOM or TIFF files or of masks), level set (.vdb) or shape about the origin: "
    "box:LX,LY,LZ  box:x0,y0,z0,x1,y1,z1  ball:R  cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  "
    "disc:R  periodic:LX,LY,LZ  periodic:LX,LY";

namespace {

const Names<Unit> kUnits{{"m", Unit::meter},
                         {"cm", Unit::centimeter},
                         {"mm", Unit::millimeter},
                         {"um", Unit::micrometer}};
const Names<RepairComponents> kRepairComponents{{"together", RepairComponents::together},
                                                {"separate", RepairComponents::separate}};
const Names<ImageSpace> kSpaces{{"lps", ImageSpace::lps}, {"ras", ImageSpace::ras}};
const Names<ShellFrom> kShellFrom{{"walls", ShellFrom::walls}, {"outer", ShellFrom::outer}};

void clipOption(OptionList& rows, std::vector<Clip>& clips) {
    Option& option = rows.custom(
        "clip", "CLIP",
        "keep only a part of the domain: box:x0,y0,z0,x1,y1,z1 or plane:nx,ny,nz,d (where "
        "n.x <= d); may be repeated",
        [&clips](const std::string& text) { clips.push_back(parseClip(text)); });
    option.get = [&clips] {
        std::vector<std::string> texts;
        for (const Clip& clip : clips) texts.push_back(clip.text);
        return texts;
    };
    option.as("clips").repeats = true;
}

/// The numbers of a list, as text.
std::string numberList(const std::vector<double>& numbers) {
    return fmt::format("{}", fmt::join(numbers, ","));
}

}  // namespace

void poseOptions(OptionList& rows, Pose& pose) {
    rows.group("Domain");
    rows.text("transform", "FILE.tfm", pose.file,
              "move the mesh or image of the domain as 3D Slicer moves a model by this linear "
              "transform (.tfm, text of ITK), after `unit` and `scale`")
        .naming(FileIn::whole);
    rows.custom(
            "matrix", "M11,M12,...",
            "move it by 3 or 4 rows of 4 numbers, one after another; the fourth column is the "
            "shift, mm",
            [&pose](const std::string& text) { pose.matrix = parseMatrix(text); },
            [&pose] { return numberList(pose.matrix); })
        .of(OptionKind::numbers);
    rows.custom(
            "rotate", "X,Y,Z,DEGREES",
            "then turn it about the axis with direction X,Y,Z through the origin, right-handed; "
            "three more numbers give another point of the axis, mm",
            [&pose](const std::string& text) { pose.rotate = parseRotation(text); },
            [&pose] { return numberList(pose.rotate); })
        .of(OptionKind::numbers);
    rows.custom(
            "translate", "X,Y,Z", "then shift it, mm",
            [&pose](const std::string& text) {
                const auto v = parseCounted("translate", text, "X,Y,Z", {3});
                pose.translate = {{v[0], v[1], v[2]}};
            },
            [&pose] { return pose.translate ? textOf(*pose.translate) : std::string(); })
        .of(OptionKind::numbers);
}

void domainArgument(OptionList& rows, DomainRecipe& domain) {
    rows.group("");
    rows.text("DOMAIN", "", domain.source, kDomainHelp).naming(FileIn::domain);
}

void domainOption(OptionList& rows, DomainRecipe& domain, const std::string& note,
                  const char* shown) {
    rows.group("Domain");
    rows.text("domain", shown, domain.source, note + kDomainHelp).naming(FileIn::domain);
}

void unitOption(OptionList& rows, const char* name, Unit& unit, const char* help) {
    rows.group("Units");
    rows.choice(name, "UNIT [mm]", unit, kUnits, help);
}

void domainOptions(OptionList& rows, DomainRecipe& domain, std::string* packGrid) {
    unitOption(rows, "unit", domain.unit, "unit of the domain's file: m, cm, mm or um");
    rows.number("scale", "F [1]", domain.scale, Range::any, "further factor on the file's lengths");
    rows.group("Domain");
    rows.text("grid", "NAME [first]", packGrid ? *packGrid : domain.gridName,
              std::string(packGrid ? "point grid, " : "") +
                  "level set, or with `threshold` fog volume, to take from a .vdb")
        .as("gridName packGrid");
    imageOptions(rows, domain);
    rows.custom(
        "slice", "z=V", "use the plane z = V of the domain; its spheres are circles",
        [&domain](const std::string& text) { domain.slice = parseSlice(text); },
        [&domain] { return domain.slice ? fmt::format("z={}", *domain.slice) : std::string(); });
    poseOptions(rows, domain.pose);
    clipOption(rows, domain.clips);
    rows.custom(
        "periodic", "AXES",
        "axes along which a box or rectangle repeats, such as xy: it has no walls there. "
        "periodic:LX,LY,LZ repeats along all",
        [&domain](const std::string& text) { domain.periodic = parseAxes(text); },
        [&domain] { return textOf(domain.periodic); });
    rows.length("voxel", "H [automatic]", domain.voxelSize, Range::positive,
                "voxel size of the distance field, mm")
        .as("voxelSize");
    repairOptions(rows, domain);
}

void thresholdOption(OptionList& rows, DomainRecipe& domain) {
    rows.group("Domain");
    rows.threshold(
        "threshold", domain.threshold,
        "take an image, or a fog volume of a .vdb, as the domain where its values are "
        "at least V. otsu: of an image, what Otsu's method finds; otsu:LEAST: the same "
        "of the values from LEAST on, such as otsu:-200 for a CT in HU, without its air");
}

void imageOptions(OptionList& rows, DomainRecipe& domain) {
    rows.group("Domain");
    thresholdOption(rows, domain);
    rows.numbers("label", "L", domain.label,
                 "label of an image to fill, by value or name; A+B joins two to one domain. With "
                 "pack and verify, A,B and all are several parts, each with its own surface");
    rows.text("mask", "LABEL=FILE", domain.mask,
              "of a label map, only the voxels that lie in that label of another one, such as "
              "those in "
              "22=vertebrae.nii.gz")
        .naming(FileIn::sample);
    imagePlacement(rows, domain);
}

void imagePlacement(OptionList& rows, DomainRecipe& domain) {
    rows.group("Domain");
    rows.custom(
            "voxel-spacing", "X,Y,Z|D",
            "distances of voxels, mm: of an image whose files state none, such as TIFF; else "
            "of the label maps that are written (-o labels:FILE)",
            [&domain](const std::string& text) { domain.voxelSpacing = parseVoxelSpacing(text); },
            [&domain] {
                return domain.voxelSpacing ? textOf(*domain.voxelSpacing) : std::string();
            })
        .of(OptionKind::numbers);
    rows.choice("space", "lps|ras [lps]", domain.space, kSpaces,
                "axes of the world of images, and of meshes that state theirs: lps (x to the left, "
                "y to the back, as in DICOM) or ras (x to the right, y to the front, as in NIfTI)");
}

void repairOptions(OptionList& rows, DomainRecipe& domain) {
    rows.group("Domain");
    rows.flag("repair", domain.repair,
              "repair a mesh that has holes, inverted or duplicate triangles, or overlapping or "
              "loose components; -o FILE.stl writes the repaired mesh");
    rows.length("repair-voxel", "H [automatic]", domain.repairVoxel, Range::positive,
                "voxel size where `repair` remeshes the surface, mm; smaller voxels keep thinner "
                "walls");
    rows.choice("repair-components", "together|separate [together]", domain.repairComponents,
                kRepairComponents,
                "how `repair` treats the surface components of the mesh. separate: each by "
                "itself, so that bones in one file stay apart unless they intersect; together: "
                "the inside is that of all triangles");
    rows.custom(
            "cavities", "keep|fill|[outer=FILE,]inner=FILE [keep]",
            "closed surface components inside others: keep leaves the cavities in them empty, "
            "fill fills them. inner=FILE removes the inside of a second mesh from DOMAIN; "
            "outer=FILE,inner=FILE replaces DOMAIN",
            [&domain](const std::string& text) { domain.cavities = parseCavities(text); },
            [&domain] { return textOf(domain.cavities); })
        .naming(FileIn::cavities);
    // The name and the words of former recipes.
    Option& former =
        rows.custom("shells", "", "former name of `cavities`", [&domain](const std::string& text) {
            domain.cavities = parseCavities(text == "cavity"  ? "keep"
                                            : text == "solid" ? "fill"
                                                              : text);
        });
    former.naming(FileIn::cavities).hiddenIf(true).excludes = "cavities";
}

void shellFromOption(OptionList& rows, DomainRecipe& domain) {
    rows.choice("shell-from", "walls|outer [walls]", domain.shellFrom, kShellFrom,
                "what `shell` is measured from. walls: all walls; outer: the outer surface alone, "
                "not the walls of cavities nor the planes of `clip`");
}

}  // namespace vdbpack
