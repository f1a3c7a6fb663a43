// The parameters of voids.
#pragma once

#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/voids/orientation.h"

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace vdbpack {

/// Which spheres a void removes: those with their centers inside it, or all that meet it.
enum class Cull { center, touch };

/// What the spheres of a pack fill.
enum class Fill {
    domain,  ///< the domain; voids are cut into the pack
    solid    ///< what the voids leave of the domain
};

/// Defaults where nothing else determines the amount of voids.
inline constexpr double kDefaultBvtv = 0.3;
inline constexpr double kDefaultProbability = 0.02;  ///< of a hole, as in the paper
inline constexpr double kDefaultAspect = 2;          ///< a / b
inline constexpr double kDefaultFoamAspect = 1.4;    ///< a / b of a foam with a direction; else 1
/// Mean b of the voids between trabeculae, in Tb.Th, before anything is measured.
inline constexpr double kRadiusPerThickness = 1.2;

/// Sizes and directions of ellipsoidal voids.
struct VoidShapeRecipe {
    SizeRequest radius;       ///< shorter half-axis b, mm; empty: chosen by the program
    double radiusFactor = 1;  ///< on these half-axes, set where a target needs it
    SizeRequest aspect;       ///< a / b; empty: chosen by the program
    OrientationRecipe orientation;
};

/// BV/TV by place.
struct BvtvField {
    std::string file;  ///< an image, or what `readScalarField` reads; empty: BV/TV does not vary
    /// Values of the file at BV/TV 0 (marrow) and 1 (bone); nothing: the file holds BV/TV itself.
    std::optional<std::pair<double, double>> range;

    bool empty() const { return file.empty(); }
};

/// What a foam has, measured in space.
struct FoamTargets {
    std::optional<double> tbth, tbsp;  ///< mean Tb.Th and Tb.Sp, mm
    std::optional<double> da;          ///< 1 - (short / long)^2
    std::optional<double> connd;       ///< Conn.D, 1/mm^3
    /// Standard deviations of the local thickness and spacing to come near to, in their means.
    std::optional<double> thicknessScatter, separationScatter;
    /// Quantiles of these distributions, 0 to 100 %, mm; empty: unknown.
    std::vector<double> thicknessQuantiles, separationQuantiles;
    bool ofBone = false;  ///< measured in bone: a target that is missed by far is no error

    bool any() const { return tbth || tbsp || da || connd; }
    /// Whether a target sets the lengths of the voids.
    bool scale() const { return tbth || tbsp || connd; }
};

/// An image, level set or mesh of a specimen, whose structure is the target.
struct SpecimenRecipe {
    std::string file;                    ///< empty: there is none
    std::string domain;                  ///< total volume; empty: the image, or the box around it
    std::optional<Threshold> threshold;  ///< of an image: solid from this grey value on
};

// The methods, with their numbers in the paper that assets/figures/README.md names.

/// An ellipsoid in each box of a lattice that a matrix or chance selects (1).
struct GridVoids {
    std::string matrix;        ///< file of 0 and 1; empty: all boxes
    std::vector<double> cell;  ///< sides of a box, mm, one or one a direction; empty: the matrix's
    std::optional<double> probability;  ///< that a box contains a void
    std::optional<double> targetBvtv;   ///< deeper than the shell, 0 to 1
};

/// An ellipsoid in each sphere of a pack of large spheres (2).
struct OverlayVoids {
    VoidShapeRecipe shape;
    std::optional<double> count;  ///< of all that fit; nothing: all
    std::optional<double> targetBvtv;
};

/// Ellipsoids at random positions, which may overlap.
struct BooleanVoids {
    VoidShapeRecipe shape;
    std::optional<double> count;  ///< mean number with centers deeper than the shell
    std::optional<double> targetBvtv;
    BvtvField bvtvField;
    std::optional<double> targetTbth;  ///< at `targetBvtv`, by the size of the voids, mm
};

/// The dilated spheres or ellipsoids of a dense pack.
struct FoamVoids {
    VoidShapeRecipe shape;
    std::optional<double> jitter;  ///< largest displacement, in radii of a void; nothing: 0.25
    std::optional<double> targetBvtv;
    BvtvField bvtvField;
    FoamTargets targets;
    SpecimenRecipe like;
};

/// Ellipsoids from a file.
struct ListedVoids {
    std::string file;
};

/// Removes spheres without making voids.
struct Thinning {
    enum class By {
        concentric,  ///< all spheres that meet balls about some of them (3)
        threshold    ///< the largest spheres (4)
    };
    By by = By::concentric;
    std::optional<double> fraction;  ///< D, above 0 to 1
    std::optional<double> targetBvtv;
};

/// Voids that the front packs among the spheres.
struct FrontHoles {
    enum class As {
        spheres,    ///< the holes themselves (5)
        ellipsoids  ///< an ellipsoid about each hole (6)
    };
    As as = As::spheres;
    VoidShapeRecipe shape;  ///< of spheres the radius alone
    std::optional<double> probability;
    std::optional<double> targetBvtv;
};

using VoidMethod = std::variant<std::monostate, GridVoids, OverlayVoids, BooleanVoids, FoamVoids,
                                ListedVoids, Thinning, FrontHoles>;

/// All parameters of voids. Lengths in mm.
struct VoidRecipe {
    VoidMethod method;  ///< nothing: there are no voids
    double shell = 0;   ///< thickness of the layer along the wall that is kept free of voids
    /// The same by place, in place of `shell`: a file that `readScalarField` reads, in mm; empty:
    /// it is the same everywhere.
    std::string shellField{};
    Fill fill = Fill::domain;
    Cull cull = Cull::center;
    bool keepConnected = false;  ///< remove spheres that are not connected to the shell
    bool measureSolid = false;   ///< report thickness, spacing, ... of what they leave
    double voxelSize = 0;        ///< of the level sets; 0: chosen by the program
    /// Length over which voids run into one another; nothing: of foam a tenth of the mean b, else
    /// 0.
    std::optional<double> blend{};
    /// Thickness of struts between voids that overlap; nothing: of foam a fifth of the mean b
    /// (2D: 0.08), else 0.
    std::optional<double> strut{};
    std::optional<double> strutShare{};  ///< of the lines between voids that have one; nothing: all

    bool empty() const { return std::holds_alternative<std::monostate>(method); }
    bool hasShell() const { return shell > 0 || !shellField.empty(); }
    /// Whether ellipsoids are made, in place of nothing or of thinning.
    bool makesVoids() const { return !empty() && !as<Thinning>(); }
    /// The parameters of a method; null for others.
    template <class Method>
    const Method* as() const {
        return std::get_if<Method>(&method);
    }
    template <class Method>
    Method* as() {
        return std::get_if<Method>(&method);
    }
};

/// "boolean", "list:FILE", ...: how people write the method; empty: none.
std::string nameOf(const VoidRecipe& recipe);

/// What several methods have; null or nothing where the method has none.
const VoidShapeRecipe* shapeOf(const VoidRecipe& recipe);
VoidShapeRecipe* shapeOf(VoidRecipe& recipe);
const BvtvField* bvtvFieldOf(const VoidRecipe& recipe);
std::optional<double> targetBvtvOf(const VoidRecipe& recipe);
std::optional<double> targetTbthOf(const VoidRecipe& recipe);
/// Of a method that has one.
void setTargetBvtv(VoidRecipe& recipe, double bvtv);

/// Whether the parameters of a foam are to be found for a structure, beside its BV/TV.
bool hasStructureTargets(const VoidRecipe& recipe);
/// Whether a target sets the lengths of the voids, so that the radii say how they spread alone.
bool scalesVoids(const VoidRecipe& recipe);

/// Refuses values out of range, contradictions and missing parameters.
/// @param hasSpheres  whether there is a pack to cut voids into.
/// @param hasFront    whether that pack is made in this run.
/// @throws ParameterError
void checkVoids(const VoidRecipe& recipe, bool hasSpheres, bool hasFront);

}  // namespace vdbpack
