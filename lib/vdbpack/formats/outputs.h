// What runs write: every kind of `-o` target, in one place.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/formats/label_outputs.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/voids/void_recipe.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Refuses before the work what would fail after it: unknown formats, folders that are not there,
/// outputs that are inputs or named twice, be it by another path or by links.
/// @param reportFile  .json or .html; may be empty.
/// @param inputs      files, with or without the prefix of a format; empty names are passed over.
/// @param further     other files that are written; empty names are passed over.
/// @throws ParameterError, IoError
void checkFiles(const std::vector<OutputTarget>& outputs, const std::string& reportFile,
                const std::vector<std::string>& inputs,
                const std::vector<std::string>& further = {});

/// The same for the files of a run that is interrupted.
void checkInterruptedFiles(const std::vector<OutputTarget>& outputs,
                           const std::vector<std::string>& inputs);

/// The voxel size of the level set of a shape with such bounds, mm.
double shapeVoxelSize(const Box<3>& bounds);

/// What a run ends with.
enum class RunKind {
    pack,     ///< spheres, and the level sets of what they lie in
    voids,    ///< level sets and a list, without spheres
    measure,  ///< nothing but contacts
    convert,  ///< spheres that are there, and the level set of their domain
};

/// Refuses outputs that a run of this kind has nothing for.
/// @param voids  how voids are made; a recipe that `checkVoids` has passed.
/// @param dim    2 or 3; 0: not known yet.
/// @throws ParameterError
void checkOutputKinds(const std::vector<OutputTarget>& outputs, RunKind run,
                      const VoidRecipe& voids, int dim = 0);

/// What a run has to write.
template <int Dim>
struct RunOutputs {
    const Pack<Dim>* pack = nullptr;                        ///< null: a .vdb holds level sets alone
    const std::vector<Ellipsoid<Dim>>* voidList = nullptr;  ///< null: none
    double sliceHeight = 0;                                 ///< 2D: z of the voids in a list, mm
    const Domain<Dim>* domain = nullptr;  ///< for the level set where `options` has none
    const TriangleMesh* wall = nullptr;   ///< of a mesh: what a .stl of `surface` holds; null: none
    const std::vector<InterfaceReport>* interfaces = nullptr;  ///< null: no parts
    LabelSource labels;
    PackWriteOptions options;  ///< unit, level sets, contact tolerance, ...
    std::string volume;        ///< a .vdb of this run with those level sets; empty: none
};

/// Writes one target, a file that is whole or absent:
///
/// - a pack, as `writePack` names them, a .usda with the contour of `solid`, or else with the
///   triangles of a mesh; where there is no pack, a .vdb of the level sets;
/// - "contacts:FILE.csv", the touching pairs; "bonds:FILE.csv", the same as `writeBonds` has them;
///   "bond-coeffs:FILE.lmp" as `writeBondCoefficients`, "interfaces:FILE.csv" as `writeInterfaces`;
///   "list:FILE.csv", the voids; "materials:FILE.csv", the materials that files of DEM programs
///   number;
/// - "labels:FILE", the ids of the spheres + 1 as a label map (.nii .nii.gz .nrrd .mha);
///   "labels-regions:", "labels-parts:" and "labels-materials:", these numbers + 1;
///   "labels-solid:", 1 (or the part + 1) within what is left of the domain;
/// - FILE.stl, the zero contour of `solid`, or the surface where nothing was cut: the triangles of
///   a mesh (as repaired), the zero contour of `surface` elsewhere; "surface:", "voids:" or
///   "solid:" before it chooses;
/// - "levelsets:FILE.vdb", the level sets alone; "fog:FILE.vdb", the inside of `solid`, or of
///   `surface`, as fog ("points:FILE.vdb", the points alone, is a pack);
/// - "blender:FILE.py", a script with files beside it; its level sets are taken from `volume`, if
///   there is one.
///
/// Where `options` has no level set, the level set of the domain is made: 256 voxels along its
/// longest side.
/// @return the files.
/// @throws ParameterError (no such thing to write), IoError
template <int Dim>
std::vector<std::string> writeOutput(const OutputTarget& output, const RunOutputs<Dim>& have);

/// Writes all targets in turn and reports each; returns the files in their order. The first .vdb
/// among them is the `volume` of the others. If one fails, those before it are complete; it and
/// those after it are unchanged.
template <int Dim>
std::vector<std::string> writeOutputs(const std::vector<OutputTarget>& outputs,
                                      const RunOutputs<Dim>& have, const Callbacks& callbacks);

}  // namespace vdbpack
