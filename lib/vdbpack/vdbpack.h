// Everything that users of the library include. The library itself never includes it.
//
// Functions on values in memory, by task:
//   domains   meshDomain, levelSetDomain, boxDomain, ballDomain, cylinderDomain, functionDomain,
//             implicitDomain; cut by clippedDomain and sliceDomain
//   pack      packSpheres, packToCount, largestBall; sizes by SizeDistribution
//   densify   densify: makes a pack denser, or removes its overlaps
//   voids     makeVoids by any method, for a target BV/TV; booleanVoids, latticeVoids,
//             voidsAtSpheres, foamVoids, readVoidList; stampVoids, cutVoids, spheresOutside,
//             keepOnly
//   verify    verifyPack, checkOverlap, checkProtrusion: independent of the packer
//   measure   solidFraction, interiorFraction, densityProfile, countContacts, listContacts,
//             pairCorrelation; measureMorphometry of a solid
//   bonds     bondsOf, apparentStiffness, elasticityOf
//   meshes    readMesh, welded, checkMesh, repairMesh, writeStl
//   files     readPack, writePack, writeContacts
//   pictures  renderPreview
// Whole runs, as the command line makes them, each from a recipe: runPack, runVoids, runCarve,
// runDensify, runVerify, runMeasure, runStiffness, runMesh, runConvert.
//
// Lengths are millimeters, distances are negative inside. Options are structures whose fields are
// set by name. Callbacks report progress and warnings, and ask whether to stop. Errors are
// exceptions (core/error.h) that state what is wrong, where, the value and a remedy.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/box.h"
#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/core/units.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/function_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/solid.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/measure/mass_offset.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/pair_correlation.h"
#include "vdbpack/measure/vacancies.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/run/run.h"
#include "vdbpack/verify/verify.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/dilated_pack.h"
#include "vdbpack/voids/make_voids.h"
#include "vdbpack/voids/orientation.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_field.h"
#include "vdbpack/voids/void_list.h"
