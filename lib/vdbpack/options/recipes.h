// What is asked for: the recipe of each command.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/voids/void_recipe.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

struct Image;
class Ranks;
class VdbGrid;

/// Base of all recipes. A command passes over what it has no use for.
struct RunSettings {
    int threads = 0;         ///< of each rank; 0: all cores
    Ranks* ranks = nullptr;  ///< with which `pack` is run; null: there are none
    double memoryLimit = 0;  ///< bytes that the process may hold; 0: what is free at the start
    std::uint64_t seed = 1;  ///< of all random numbers
    double contactTolerance = 1e-3;  ///< gap up to which spheres touch, in smaller radii
    std::vector<OutputTarget> outputs;
    Unit outUnit = Unit::millimeter;  ///< of the lengths in them
    bool images = false;              ///< files for viewers hold the images in a periodic cell, too
    std::string density;  ///< of the spheres in DEM files, as `particleDensity` takes it
    GreyRecipe grey;
    BondOptions bonds;       ///< with `contactTolerance` as their tolerance
    PreviewOptions preview;  ///< picture; without a file: none
    std::string reportFile;  ///< .json or .html; empty: none
    std::string command;     ///< for the report; empty: the task and what it works on
    /// Names and values of options, for the page of a report.
    std::vector<std::pair<std::string, std::string>> givenOptions;
    /// Names and values of the options in which the runs of a study differ.
    std::vector<std::pair<std::string, std::string>> varied;
    /// TOML with the options that repeat the run ({seed} for the seed): written beside the first
    /// output as NAME.recipe.toml. Empty: none is written.
    std::string optionsText;
    /// That the recipe states whose run is repeated; a run with another one warns.
    std::optional<std::uint64_t> repeatedHash;
};

/// What a pack is made from.
struct PackRecipe : RunSettings {
    DomainRecipe domain;
    SizeRequest radius;  ///< empty: uniform, ratio 1:2, about 100,000 spheres
    /// File with a factor on the radii by place: as `readScalarField` reads it, or an image; empty:
    /// none.
    std::string sizeField;
    SizeRequest shellRadius;  ///< of spheres in the shell of `voids`; empty: the radii of all
    WeightBy weightBy = WeightBy::count;  ///< for table:FILE
    double targetCount = 0;               ///< scale the radii to about this many; 0: as given
    /// How the front packs; sizes, seed, threads and ranks are set by the recipe.
    PackOptions packing{SizeDistribution::uniform(1, 2)};
    /// How spheres are moved and added afterwards, with the gap of `packing`; fraction 0: they are
    /// not.
    DensifyOptions densify;
    /// Whether `densify` begins with spheres at random points (`DensifyOptions::random`) in place
    /// of a front.
    bool randomStart = false;
    /// Whether the front's spheres are settled (`DensifyOptions::settle`).
    bool settle = false;
    VoidRecipe voids;
    std::string existing;  ///< pack file with spheres to pack around; empty: none
    /// What a program has in memory, mm, in place of the file that `existing` names in messages.
    std::shared_ptr<const Pack<3>> givenExisting;
    Unit packUnit = Unit::millimeter;  ///< of `existing`, if the file states none
    PackColumns packColumns;           ///< of `existing`, in place of its names
    double packRadius = 0;             ///< mm, of the spheres of `existing` if it has no radii
    /// What several parts are filled with, each in a domain of its own: bone and implant. Where
    /// they overlap, the later one has the space. Of a part, files and threads are not used; empty:
    /// `domain` is the only one, unless its `label` names several.
    std::vector<PackRecipe> parts;
    std::string name;       ///< of a part, in reports and level sets
    std::string partsFile;  ///< that `parts` were read from; empty: none
};

/// Voids and what they leave of a domain, without a pack.
struct VoidsRecipe : RunSettings {
    DomainRecipe domain;
    VoidRecipe voids;
};

/// A pack from a file of any program, and what to compare it with.
struct InputPack : RunSettings {
    std::string pack;  ///< file, any format that readPack supports
    /// What a program has in memory, mm, in place of the file that `pack` names in messages.
    std::shared_ptr<const Pack<3>> given;
    Unit packUnit = Unit::millimeter;
    PackColumns packColumns;  ///< in place of the names in the file
    double packRadius = 0;    ///< mm, of its spheres if it has no radii; 0: such a file is refused
    std::string packGrid;     ///< point grid in a .vdb; empty: the first
    DomainRecipe domain;      ///< `source` empty: what needs no domain
    SizeRequest radius;       ///< what the radii are compared with; empty: nothing
    WeightBy weightBy = WeightBy::count;

    /// `radius` in a dimension, 2 or 3.
    std::optional<SizeDistribution> sizes(int dim) const { return radius.find(dim, weightBy); }
};

struct VerifyRecipe : InputPack {
    double gap = 0;                    ///< least distance that the spheres must keep, mm
    std::uint64_t vacancySamples = 0;  ///< points at which to search for vacancies; 0: none
    /// Of a pack of several parts, with its column `part`: the domains that they fill, as in
    /// PackRecipe; empty: `domain`, unless its `label` names several.
    std::vector<PackRecipe> parts;
    std::string partsFile;  ///< that `parts` were read from; empty: none
};

/// What voids are cut into a pack that exists.
struct CarveRecipe : InputPack {
    VoidRecipe voids;
};

/// A pack that exists, made denser, or freed of its overlaps.
struct DensifyRecipe : InputPack {
    DensifyOptions densify;  ///< fraction 0: overlaps are removed, and no sphere is added
};

/// The apparent stiffness of the bonded spheres of a pack; `outputs` are lists of contacts and
/// bonds.
struct StiffnessRecipe : InputPack {
    /// Spheres whose surface is at most so far from the wall of the domain move with it, mm;
    /// nothing: a tenth of the mean radius.
    std::optional<double> boundary;
    /// Axis 0 to 2 along which two rigid grips press the body, in place of six strains; nothing:
    /// none.
    std::optional<int> press;
    /// Depth of a grip, mm: it holds the spheres whose centers lie in it; nothing: four mean
    /// radii, or deeper until these cover the ends.
    std::optional<double> grip;
    /// Young's modulus (MPa) and Poisson's ratio for which bonds are sought; `fits` false: none.
    /// With `press`, the modulus alone (the ratio is NaN), of bonds with the shear ratio that is
    /// set.
    bool fits = false;
    double wantedModulus = 0, wantedPoisson = 0;
};

struct MeasureRecipe : InputPack {
    /// What a program has in memory, in place of the solid that `pack` names in messages; at most
    /// one of them, the level set in mm, the others in `packUnit`.
    std::shared_ptr<const VdbGrid> solid;
    std::shared_ptr<const TriangleMesh> solidMesh;
    std::shared_ptr<const Image> solidImage;
    double shell =
        0;  ///< thickness of the layer along the wall that is measured apart, mm; 0: none
    /// Of a pack: morphometry of the union of its spheres, too, in voxels of `domain.voxelSize` (0:
    /// a sixth of the mean radius).
    bool sphereMorphometry = false;
    /// Added to the radii there, mm, so that contacts become necks; nothing: 5 % of the mean
    /// radius.
    std::optional<double> dilation;
};

/// `pack` is what is converted, `packGrid` the point grid or level set in a .vdb. With
/// `domain.source` level sets and surface of that domain can be written beside the spheres;
/// the level set made of a mesh has voxels of `domain.voxelSize`, too. Of a solid, `domain` says
/// how it is read, without a source of its own. `outputs` or a picture are required; `radius` and
/// `reportFile` are not used.
struct ConvertRecipe : InputPack {};

/// `pack` is shown, and with `domain.source` the wall of that domain; or a solid, as by
/// `ConvertRecipe`. `reportFile` is the page
/// (empty: NAME.view.html in the current folder, with the name of the pack's file);
/// `preview.cut`, `preview.color` and `preview.column` are how the view begins. `outputs`,
/// `preview.file` and `radius` are not used.
struct ViewRecipe : InputPack {};

/// Outputs are .stl, in mm.
struct MeshRecipe : RunSettings {
    DomainRecipe domain;  ///< source, unit, scale, and how to repair
    bool check = false;   ///< a mesh that cannot be packed with these settings fails
};

struct ImageRecipe : RunSettings {
    DomainRecipe domain;  ///< source, unit, scale, spacing, space and threshold
};

/// How the spheres of a run are bonded: up to the gap of contacts.
BondOptions bondOptionsOf(const RunSettings& settings);

/// `text` with each {OPTION} replaced by the value of that option.
std::string withOption(std::string text, const std::string& option, const std::string& value);
/// `name` with each {seed} replaced.
std::string withSeed(const std::string& name, std::uint64_t seed);

/// Sets the seed, and puts it in place of {seed} in names of files.
void setSeed(RunSettings& settings, std::uint64_t seed);

/// The recipe of a run with one of several seeds.
template <class Recipe>
Recipe recipeForSeed(Recipe recipe, std::uint64_t seed) {
    setSeed(recipe, seed);
    return recipe;
}

/// "out/femur.recipe.toml" beside "out/femur.vdb", the first of several outputs; empty if there are
/// none.
std::string recipeFileFor(const std::vector<OutputTarget>& outputs);

}  // namespace vdbpack
