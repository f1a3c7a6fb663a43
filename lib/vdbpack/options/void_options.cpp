// Options about voids.
#include "vdbpack/options/option_rows.h"

namespace vdbpack {

namespace {

const Names<Cull> kCulls{
    {"centre", Cull::center}, {"center", Cull::center}, {"touch", Cull::touch}};

/// The rows of voids, in the order of the help.
struct VoidRows {
    OptionList& rows;
    VoidRequest& voids;
    DomainRecipe& domain;
    bool front;    ///< spheres are packed, so that voids may be packed with them
    bool spheres;  ///< there are spheres to cut, packed or read

    static std::string orElse(bool first, const char* a, const char* b) { return first ? a : b; }

    void addMethod() const;
    void addTargets() const;
    void addSamples() const;
    void addShapes() const;
    void addAmounts() const;
    void addDirections() const;
};

void VoidRows::addMethod() const {
    std::vector<std::string> methods{"grid", "overlay", "boolean", "foam", "list:"};
    if (spheres) methods.insert(methods.end(), {"concentric", "threshold"});
    if (front) methods.insert(methods.end(), {"mixed", "ellipses"});
    rows.text("voids", "METHOD", voids.method,
              "how voids are made: grid, overlay, " +
                  orElse(spheres, "concentric, threshold, ", "") +
                  orElse(front, "mixed, ellipses, ", "") + "boolean, foam or list:FILE")
        .naming(FileIn::voids)
        .taking(methods);
    rows.length("shell", "T [0]", voids.shell, Range::notNegative,
                "thickness of the layer along the wall that stays without voids, mm" +
                    orElse(spheres, "; without `voids` it only sets the region of each sphere", ""))
        .as("shell voids.shell");
    rows.text("shell-field", "FILE", voids.shellField,
              "the same by place, in place of `shell`: a .csv (x, y, z, value) or a .vdb grid of "
              "floats, in mm")
        .naming(FileIn::whole);
    shellFromOption(rows, domain);
    rows.choice("cull", "centre|touch [centre]", voids.cull, kCulls,
                "spheres that voids remove. centre: those with centers in a void; touch: all that "
                "reach into one")
        .hiddenIf(!spheres);  // accepted, without effect
    rows.flag("keep-connected", voids.keepConnected,
              "remove what is not connected to the shell; without a shell, all but the largest "
              "component");
    rows.flag(
        "measure-solid", voids.measureSolid,
        "measure what the voids leave deeper than the shell, as measure does: Tb.Th, Tb.Sp, "
        "DA, Conn.D, in report and table; takes more time and memory than all else (see dry-run)");
}

void VoidRows::addTargets() const {
    const std::string packed = front ? ", mixed, ellipses" : "";
    rows.number("target-bvtv", "F", voids.targetBvtv, Range::any,
                "BV/TV to reach in the part deeper than the shell. It sets the number of voids "
                "(boolean, overlay), their size (foam)" +
                    orElse(spheres, ", the probability (grid", " or the probability (grid") +
                    packed + ")" + orElse(spheres, " or D (concentric, threshold)", ""));
    rows.text("bvtv-field", "FILE", voids.bvtvField,
              "BV/TV by place (boolean, foam): the grey values of an image such as a CT, a .vdb "
              "grid of floats, or a .csv (x, y, z, value), in mm; without `target-bvtv`, its mean "
              "is the target")
        .naming(FileIn::whole);
    rows.numbers(
        "bvtv-range", "MARROW,BONE", voids.bvtvRange,
        "values of that field at BV/TV 0 (marrow) and 1 (bone), linear between them; needed "
        "for an image, 0,1 for others");
    rows.length("target-tbth", "T", voids.targetTbth, Range::any,
                "mean thickness Tb.Th of trabeculae to reach, mm (foam; boolean with "
                "`target-bvtv`)");
    rows.length("target-tbsp", "T", voids.targetTbsp, Range::any,
                "mean spacing Tb.Sp to reach, mm (foam)");
    rows.number("target-da", "D", voids.targetDa, Range::any,
                "degree of anisotropy to reach, 1 - (short / long)² as measure prints it (foam)");
    rows.number("target-connd", "C", voids.targetConnd, Range::any,
                "connectivity density Conn.D to reach, 1/mm³ (foam)");
}

void VoidRows::addSamples() const {
    rows.text("trabecular", "NAME|list", voids.trabecular,
              "targets from published morphometry, for those that are not given (foam); list "
              "prints the names with their numbers and sources");
    rows.text("like", "SAMPLE", voids.like,
              "targets and main direction from a specimen: an image, a level set or a mesh (foam)")
        .naming(FileIn::whole);
    rows.text("like-domain", "DOMAIN", voids.likeDomain,
              "total volume of that specimen (all of an image, else the box around the solid)")
        .naming(FileIn::domain);
    rows.threshold("like-threshold", voids.likeThreshold,
                   "of an image with grey values: those from this on are solid");
    rows.length("void-voxel", "H [1/4 half-axis]", voids.voxelSize, Range::positive,
                "voxel size of the level sets of voids, mm")
        .as("voids.voxelSize");
}

void VoidRows::addShapes() const {
    rows.text("void-radius", orElse(spheres, "SPEC [1.5 to 2.5 largest spheres]", "SPEC").c_str(),
              voids.radius,
              "shorter half-axis b of the voids, " +
                  (spheres ? std::string("written as `radius`") : kRadiusSpec) + ", mm (" +
                  orElse(front, "mixed: radius of the holes; ", "") +
                  "overlay: voids are placed by packing spheres of radius b times aspect; foam: "
                  "before they are dilated)")
        .as("voids.radius")
        .naming(FileIn::sizes);
    rows.text("void-aspect", "SPEC [constant:2; foam 1.4, without a direction 1]", voids.aspect,
              "ratio of the half-axes a / b, written as " +
                  orElse(spheres, "`radius`", "`void-radius`"))
        .as("voids.aspect")
        .naming(FileIn::sizes);
    rows.length("void-blend", "K [0; foam 0.1 of the mean b]", voids.blend, Range::any,
                "length over which voids run into one another, mm: rounds the edges between them, "
                "and opens walls that are thinner")
        .as("voids.blend");
    rows.number("void-jitter", "J [0.25]", voids.jitter, Range::any,
                "foam: largest displacement of a void, in its radii, 0 to 1; 0 leaves walls with "
                "many small holes, 1 thick struts that may be loose")
        .as("voids.jitter");
    rows.length("void-strut", "T [0; foam 0.2 of the mean b, 2D 0.08]", voids.strut, Range::any,
                "thickness of the struts that remain between voids that overlap, along the lines "
                "where three of them (2D: two) are equally near, mm")
        .as("voids.strut");
    rows.number("void-strut-share", "P [1]", voids.strutShare, Range::any,
                "share of these lines that have a strut, 0 to 1")
        .as("voids.strutShare");
}

void VoidRows::addAmounts() const {
    rows.number("void-count", "N", voids.count, Range::any,
                "number of voids. boolean: mean number with centers deeper than the shell; voids "
                "of the same density lie around that part. overlay: number taken of all that fit "
                "(default: all)")
        .as("voids.count");
    rows.number("void-probability", orElse(front, "P [grid 1, else 0.02]", "P [1]").c_str(),
                voids.probability, Range::any,
                "probability that a box contains a void (grid)" +
                    orElse(front, ", that a sphere is a hole (mixed, ellipses)", ""))
        .as("voids.probability");
    rows.number("delete-fraction", "D", voids.deleteFraction, Range::any,
                "D of method concentric: share of the spheres that is removed, in balls of radius "
                "Rmin/D to Rmax/D around random spheres. D of method threshold: spheres with radii "
                "above Rmax - D (Rmax - Rmin) are removed")
        .hiddenIf(!spheres);  // accepted, without effect
    rows.text("void-matrix", "FILE", voids.matrix,
              "file with 0 or 1 for each box of grid, top row first")
        .as("voids.matrix")
        .naming(FileIn::whole);
    rows.numbers(
            "void-cell", "SIZE", voids.cell,
            "sides of a box of grid, mm: one value, or one for each direction (default: as many "
            "boxes as the matrix has)")
        .as("cell");
}

void VoidRows::addDirections() const {
    OrientationRecipe& orientation = voids.orientation;
    rows.custom(
            "void-angles", "ANGLES",
            "directions of the long axes. \"tz=SPEC;tx=SPEC\": along z, rotated by tx about x, "
            "then by tz about z. \"phi=SPEC\" (2D): along x, rotated by phi. isotropic: no "
            "preferred direction. SPEC is V, uniform:A,B or normal:MEAN,SD,A,B, in rad or with "
            "suffix deg. With `void-axis` or `void-field`: scatter about that direction. Default "
            "without those: isotropic for boolean and foam, else within 0.358 rad of z (2D: of x)",
            [&orientation](const std::string& text) {
                orientation.angles = VoidAngles::parse(text);
            },
            [&orientation] { return orientation.angles ? orientation.angles->text : ""; })
        .as("orientation.angles");
    rows.custom(
            "void-axis", "X,Y,Z|long",
            "direction of the long axes; long: that of the domain, the first of its principal axes",
            [&orientation](const std::string& text) { orientation.axis = VoidAxis::parse(text); },
            [&orientation] { return orientation.axis ? orientation.axis->text : ""; })
        .of(OptionKind::numbers)
        .as("orientation.axis");
    rows.text("void-field", "FILE", orientation.field,
              "direction of the long axes at each position: .vdb (vectors, or the main axis of a "
              "tensor) or .csv (x, y, z and a direction or six stress components), in mm")
        .as("orientation.field")
        .naming(FileIn::whole);
}

}  // namespace

void voidOptions(OptionList& rows, VoidRequest& voids, DomainRecipe& domain, VoidsIn in) {
    rows.group("Voids");
    const VoidRows all{rows, voids, domain, in == VoidsIn::pack, in != VoidsIn::nothing};
    all.addMethod();
    all.addTargets();
    all.addSamples();
    all.addShapes();
    all.addAmounts();
    all.addDirections();
}

}  // namespace vdbpack
