// Options about spheres: sizes, how they are packed and moved, what they are made of.
#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/options/option_rows.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace vdbpack {

const char* const kRadiusSpec =
    "constant:R | uniform:A,B | normal:MEAN,SD,A,B | lognormal:MEDIAN,SIGMA,A,B | table:FILE | "
    "psd:FILE";

namespace {

constexpr std::uint64_t kMostDensityClasses = 1000, kMostBondClasses = 10'000;

template <class Value>
std::pair<std::string, Value> named(Value value) {
    return {nameOf(value), value};
}

const Names<WeightBy> kWeights{{"count", WeightBy::count}, {"volume", WeightBy::volume}};
const Names<Effort> kEfforts{named(Effort::fast), named(Effort::normal), named(Effort::dense)};
const Names<Order> kOrders{named(Order::waves),  named(Order::sweep),       named(Order::wall),
                           named(Order::center), {"center", Order::center}, named(Order::fifo)};

const Names<bool> kStarts{{"front", false}, {"random", true}};
const Names<bool> kOnOff{{"on", true}, {"off", false}};

double solidFractionIn(const std::string& text) {
    if (text == "max") return std::numeric_limits<double>::infinity();
    double fraction = 0;
    if (!parseReal(text, fraction) || !(fraction > 0 && fraction < 1))
        throw ParameterError(
            "`densify` '" + text +
            "': must be max or one solid fraction above 0 and below 1, such as 0.64");
    return fraction;
}

void sizesOption(OptionList& rows, const char* name, SizeRequest& sizes, std::string help) {
    rows.custom(
            name, "SPEC", std::move(help),
            [&sizes, name](const std::string& text) {
                if (text.empty())
                    throw ParameterError("`" + std::string(name) + "`: must not be empty");
                sizes = sizesOf(name, text);
            },
            [&sizes] { return sizes.spec(); })
        .naming(FileIn::sizes);
}

}  // namespace

SizeRequest sizesOf(const std::string& name, const std::string& text) {
    try {
        return SizeRequest::parse(text);
    } catch (const ParameterError& error) {
        throw ParameterError("`" + name + "`: " + error.what());
    }
}

void sizeOptions(OptionList& rows, SizeRequest& radius, WeightBy& weightBy, const char* note) {
    rows.group("Spheres");
    sizesOption(rows, "radius", radius, std::string(kRadiusSpec) + ", in mm" + note);
    rows.choice("weight-by", "count|volume [count]", weightBy, kWeights,
                "whether the weights of table:FILE are shares of the number or of the volume of "
                "spheres");
}

void gapOption(OptionList& rows, double& gap, const char* help) {
    rows.group("Spheres");
    rows.length("gap", "G [0]", gap, Range::notNegative, help);
}

void densifyOption(OptionList& rows, double& fraction, const char* help) {
    rows.group("Spheres");
    rows.custom(
            "densify", "F|max", help,
            [&fraction](const std::string& text) { fraction = solidFractionIn(text); },
            [&fraction]() -> std::string {
                if (!(fraction > 0)) return {};
                return std::isfinite(fraction) ? fmt::format("{}", fraction) : "max";
            })
        .of(OptionKind::numbers);
}

void deviceOption(OptionList& rows, DeviceChoice& device) {
    using Kind = DeviceChoice::Kind;
    rows.group("Run");
    rows.custom(
            "device", "auto|cpu|gpu[:N] [auto]",
            "what takes the steps in which `densify` and `settle` move spheres; the pack is the "
            "same. auto: a GPU where OpenCL finds one that is quicker; gpu:N: device N of OpenCL, "
            "from 0, GPUs first",
            [&device](const std::string& text) {
                if (text == "auto") {
                    device = {};
                } else if (text == "cpu") {
                    device = {Kind::processor, 0};
                } else {
                    device = {Kind::gpu, 0};
                    std::int64_t number = 0;
                    if (text.rfind("gpu:", 0) == 0 && parseInteger(text.substr(4), number) &&
                        number >= 0 && number < 1000)
                        device.number = static_cast<int>(number);
                    else if (text != "gpu")
                        throw ParameterError("`device` '" + text +
                                             "': must be auto, cpu, gpu, or gpu:N with the number "
                                             "N of a device from 0");
                }
            },
            [&device]() -> std::string {
                if (device == DeviceChoice()) return {};
                return device.kind == Kind::processor ? "cpu"
                                                      : fmt::format("gpu:{}", device.number);
            })
        .passing()
        .offPage();
}

void sphereOptions(OptionList& rows, PackRecipe& recipe) {
    sizeOptions(rows, recipe.radius, recipe.weightBy,
                " (default: uniform with ratio 1:2, about 100,000 spheres)");
    rows.text("size-field", "FILE", recipe.sizeField,
              "factor on the radii by place, that of the center of each sphere: a .vdb grid of "
              "floats, a .csv (x, y, z, value) or an image; from its smallest to its largest "
              "value at most 1:20")
        .naming(FileIn::whole);
    sizesOption(rows, "shell-radius", recipe.shellRadius,
                "radii of the spheres with centers in the shell (`shell`), like `radius`, which is "
                "then that of the others");
    constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
    rows.count("target-count", "N", recipe.targetCount, 1, kMost,
               "scale the radii so that about N spheres are written: those that voids leave, with "
               "those that `densify` adds, without those of `existing`");
    rows.count("max-count", "N", recipe.packing.maxCount, 1, kMost,
               "stop when N spheres are placed");
    rows.choice("effort", "fast|normal|dense [normal]", recipe.packing.effort, kEfforts,
                "fast: positions in the order of the sweep; normal: first those where the sphere "
                "touches an additional sphere or wall (equal ones: many); dense: the same with "
                "more pending radii to choose from, in larger blocks");
    rows.choice(
        "order", "waves|sweep|wall|centre|fifo [waves]", recipe.packing.order, kOrders,
        "position that is filled next. waves: the lowest along a diagonal with waves across "
        "it, so that contacts gather around no direction; sweep: without waves (nearly "
        "equal spheres and packs with holes always): some denser, contacts gather around the "
        "diagonal; wall: nearest to the wall; centre: nearest to the middle; fifo: the first "
        "found. The last three run on one thread, for comparison");
    rows.length("block-side", "MM", recipe.packing.blockSide, Range::positive,
                "edge of the blocks of which each is filled by one thread, at least 8 largest "
                "radii. Shorter ones than the usual 20 keep more than some 500 cores busy, and "
                "cost some solid fraction");
    gapOption(rows, recipe.packing.gap,
              "least distance between spheres, and between spheres and the wall, mm");
    densifyOption(rows, recipe.densify.fraction,
                  "after packing, move and add spheres until the solid fraction is F, or as high "
                  "as possible (max); radii do not change");
    rows.choice("start", "front|random [front]", recipe.randomStart, kStarts,
                "random: spheres at random points, pushed apart until they have the solid fraction "
                "of `densify`, from loose packs to the densest: no front leaves its directions in "
                "the pack, and `target-count` is met within a few");
    rows.choice("settle", "on|off [off]", recipe.settle, kOnOff,
                "after packing, move the spheres until neither their contacts nor their density "
                "tell where the packing began: isotropic packs of the same spheres, with fewer "
                "contacts and in three to five times the time");
    rows.text("existing", "FILE", recipe.existing,
              "pack around the spheres of a file in any pack format; outputs contain these "
              "spheres first, unchanged")
        .naming(FileIn::pack);
    packReadingOptions(rows, recipe.packUnit, recipe.packColumns, recipe.packRadius, "`existing`");
}

void densityOption(OptionList& rows, std::string& density) {
    rows.group("Spheres");
    rows.numbers("density", "D|0=D,1=D|bulk:D [1000]", density,
                 "density of the spheres in the files of LAMMPS and LIGGGHTS, kg/m3; 0=D,1=D: by "
                 "region; bulk:D: all spheres together weigh as much as the domain at density D");
}

void greyOptions(OptionList& rows, GreyRecipe& grey) {
    rows.group("Grey values");
    rows.texts("sample", "NAME=IMAGE", grey.samples,
               "add a column: the mean of an image, such as a CT, over each sphere; may be "
               "repeated")
        .as("samples")
        .naming(FileIn::sample);
    rows.length("sample-length", "L", grey.sampleLength, Range::notNegative,
                "that mean is over a ball of at least this diameter, mm: for spheres that are "
                "smaller than the voxels, or a noisy image")
        .as("sampleLength")
        .needs = "sample";
    rows.numbers("calibrate", "[NAME=]SLOPE,INTERCEPT", grey.calibration,
                 "density of each sphere, SLOPE * grey value + INTERCEPT, kg/m3 (= mg/cm3), as "
                 "column density_kg_m3 and in the files of LAMMPS and LIGGGHTS; of `sample`, or of "
                 "the column NAME")
        .as("calibration");
    rows.numbers(
        "modulus", "A,B|E", grey.modulus,
        "Young's modulus of each sphere, A * density^B, MPa, of the density in g/cm3, as "
        "column modulus_MPa; E alone: the same for all, without grey values. Parts may have "
        "their own");
    rows.count("density-classes", "N [10]", grey.classes, 1, kMostDensityClasses,
               "classes of equal width that the densities fall into: materials of YADE and types "
               "of LAMMPS, listed by materials:FILE.csv")
        .as("grey.classes")
        .needs = "calibrate";
}

void bondOptions(OptionList& rows, BondOptions& bonds) {
    rows.group("Bonds");
    rows.number("bond-modulus", "E [1000]", bonds.law.modulus, Range::positive,
                "Young's modulus of the bonds between spheres without a column modulus_MPa, MPa; "
                "for bonds:FILE.csv and for stiffness");
    rows.number("bond-radius", "F [1]", bonds.law.radiusFactor, Range::positive,
                "radius of a bond, divided by that of its smaller sphere");
    rows.number("bond-shear", "RATIO [0.4]", bonds.law.shearRatio, Range::notNegative,
                "tangential divided by normal stiffness of a bond; also its torsion");
    rows.flag("bond-hinged", bonds.law.isHinged, "bonds resist neither bending nor torsion");
    rows.number("bond-strength", "STRAIN", bonds.law.breakingStrain, Range::positive,
                "strain in tension at which bonds break, such as 0.0078: strength = STRAIN * "
                "modulus");
    rows.number("bond-shear-strength", "RATIO [0.51]", bonds.law.shearStrength, Range::positive,
                "shear strength of bonds, divided by their tensile strength")
        .needs = "bond-strength";
    rows.count("bond-classes", "N [1]", bonds.classes, 0, kMostBondClasses,
               "classes of bonds by stiffness, bond types of lammps-bonds: for bond_style "
               "bpm/rotational; 0: a type for each bond, for bond_style harmonic. "
               "bond-coeffs:FILE.lmp has their coefficients");
    rows.number("interface-tol", "T", bonds.interfaceTolerance, Range::notNegative,
                "spheres of two parts are bonded up to a gap of this share of the smaller radius, "
                "if it is larger than `contact-tol`, which holds for all other pairs")
        .as("interfaceTolerance");
}

std::pair<double, double> parseModulusAndPoisson(const std::string& text) {
    auto numbers = parseNumberList(text);
    if (numbers && numbers->size() == 1)
        numbers->push_back(std::numeric_limits<double>::quiet_NaN());
    if (!numbers || numbers->size() != 2 || !((*numbers)[0] > 0) || (*numbers)[1] <= -1 ||
        (*numbers)[1] >= 0.5)
        throw ParameterError("`bond-modulus-for` '" + text +
                             "': write E,NU: MPa above 0, and a Poisson's ratio between -1 and "
                             "0.5, such as 500,0.25; or with `press` E alone");
    return {(*numbers)[0], (*numbers)[1]};
}

}  // namespace vdbpack
