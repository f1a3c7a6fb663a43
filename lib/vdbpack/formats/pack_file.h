// Files of packs, by the extension of their name, and of their contacts.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/units.h"
#include "vdbpack/measure/contacts.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

class VdbGrid;
struct TriangleMesh;

/// Length of an edge of the point grid's voxels in a .vdb file, in the unit of `measure`: a power
/// of two, about 8 points a voxel. Positions that are whole multiples of 2^-25 of it survive the
/// file's 32-bit offsets unchanged.
/// @param count    spheres; 1 is returned where there are none.
/// @param measure  volume (2D: area) that they fill, length^Dim.
double pointVoxelSize(double count, double measure, int dim);

/// Edge of the smallest voxel that OpenVDB takes, in the unit of its file: it refuses transforms
/// with a determinant below 3e-15 (openvdb/math/Maps.h, of any version).
inline constexpr double kSmallestVdbVoxel = 1.45e-5;

/// Refuses voxels of level sets that a file cannot hold. @param edge  mm.
/// @throws ParameterError naming the file, the edge in its unit and the remedy
void requireVdbVoxel(double edge, Unit unit, const std::string& file);

/// Density of the spheres where none is given, kg/m³: the density of water.
inline constexpr double kDefaultDensity = 1000;

struct PackWriteOptions {
    Unit unit = Unit::millimeter;  ///< of what is written
    std::string generator;         ///< program and version, recorded where the format can
    /// Written beside the points in a .vdb, under the names they have (`surface`, ...).
    std::vector<std::shared_ptr<const VdbGrid>> levelSets;
    /// Beside the points in a .usda or .usdz, under the name `surfaceName`; null: none.
    const TriangleMesh* surface = nullptr;
    std::string surfaceName = "surface";
    /// Voxel edge of the point grid, mm; taken as the nearest power of two in `unit`. 0: from the
    /// volume of the spheres, and up to eight times finer where that keeps every position exact.
    double pointVoxel = 0;
    /// Density of the spheres for DEM programs, kg/m³; 0: the numbers of the pack's column
    /// `density_kg_m3`, or of `density`, unconverted, or else `kDefaultDensity`.
    double particleDensity = 0;
    /// The same by material (`Materials::withoutClass`); other materials have `particleDensity`.
    std::map<std::int32_t, double> materialDensity;
    BondOptions bonds;  ///< the tolerance also decides which pairs are in contact
    /// Drawn around the circles of an .svg, and part of the picture: the bounds of the domain, mm.
    std::optional<Box<2>> frame;
    /// Of a periodic cell, write the images that protrude into it, too (`withImages`), but not for
    /// YADE and LAMMPS, which make their own.
    bool images = false;
};

/// Writes a pack; the format by prefix ("yade:f.txt", "csv:table") or extension: .vdb .vtp .ply
/// .csv .xyz .npz .usda (.usd) .usdz .data (or lammps:, liggghts:, lammps-bonds:), .pvtp, .vtkhdf
/// (.hdf), points: for a .vdb without level sets, and .svg for circles. Whole or absent: a former
/// file stays as it is until the new one is complete.
///
/// .csv, .vtp, .npz and .xyz keep every double and every column (texts in .xyz as one word each).
/// .pvtp names its one piece, NAME_0000.vtp. .vtkhdf, an unstructured grid of vertices, keeps every
/// double and every column of numbers; columns of texts are left out. .usda and .usdz, which holds
/// one, have every column, under names with letters, digits and '_' (the original names are
/// recorded); programs round their positions and diameters to floats, about an origin near the
/// spheres. They are not read back. .vdb keeps positions to 2^-26 of a voxel (in mm the positions
/// of a packer exactly) and radii as float; points are stored by position, and `readPack` returns
/// them sorted by id. .ply (double positions, radius, id) and YADE (positions, radius, material)
/// hold no further attributes. .svg is a picture: y up, so cy = -y, numbers to six digits of its
/// extent, colors by region. Empty attributes are left out. The unit is recorded in every format
/// but .csv, which has no metadata. 2D: z = `sliceHeight`.
///
/// spherepack: is for YADE's SpherePack.load: x y z r clumpId, and the lengths of a cell that is
/// periodic along all axes; no unit.
///
/// .data is for LAMMPS's atom style sphere and LIGGGHTS's granular: `id type diameter density x y
/// z` in a box around whole spheres. type is the pack's column `type`, or else 1 + the material
/// (`Materials`), or 1; spheres with type 0, which were added to those of a file, have the types
/// after its largest one. If the smallest id is 0, ids are one more in the file; if some are
/// negative, equal or beyond 2^31 - 1, atoms are numbered from 1. Densities go with the unit of
/// length: kg/m³ (LAMMPS's units si), g/cm³ (cgs), pg/µm³ (micro), and t/mm³ for mm, which with
/// seconds gives forces in N and pressures in MPa. The title records all that, and `readPack`
/// undoes it. lammps-bonds adds a bond of type 1 for each touching pair; it is for atom style
/// hybrid sphere bond: `id type x y z diameter density molecule`.
///
/// @throws ParameterError (unknown format; spheres as .svg; attributes of the wrong length; a
/// sphere that is not finite or has no positive radius; an empty frame), IoError
template <int Dim>
void writePack(const Pack<Dim>& pack, const std::string& file,
               const PackWriteOptions& options = {});

/// Writes the level sets of `options` alone as a .vdb file. Whole or absent. @throws IoError
void writeLevelSets(const std::string& file, const PackWriteOptions& options);

/// Writes the inside of a level set as fog, alone in a .vdb: FloatGrid `density`, 0 outside, rising
/// from 0 at the wall to 1 at the depth of its band. Whole or absent. `options.levelSets` are
/// ignored. @throws IoError
void writeFog(const VdbGrid& levelSet, const std::string& file, const PackWriteOptions& options);

/// Checks that `file` names a format that `writePack` knows, and one for packs of `dim` dimensions
/// (0: not known yet). Cheap: to be called before the work whose result is written.
/// @throws ParameterError if not, with the list of formats.
void checkPackFormat(const std::string& file, int dim = 0);

/// Whether the format that `file` names has a surface beside the spheres
/// (`PackWriteOptions::surface`).
bool holdsSurface(const std::string& file);

/// Whether it has the mass of each sphere, or its density.
bool holdsMasses(const std::string& file);

/// A generator that states the origin of its packs: "vdb_pack 1.0; axes LPS; contact tolerance
/// 0.1".
std::string generatorWith(const std::string& program, const PackOrigin& origin);

/// The prefixes that name formats of packs ("yade:").
std::vector<std::string> packPrefixes();

/// The path in a name: what follows the prefix of a format ("yade:f.txt"), else all of it. @throws
/// ParameterError for a prefix without a file
std::string packPath(const std::string& file);

/// Names for the columns of a file without names, or with names that are not known.
struct PackColumns {
    std::vector<std::string> inOrder;  ///< of all columns; empty: the names in the file
    /// A name ("radius", "x [m]") and the column of the file that gets it.
    std::vector<std::pair<std::string, std::string>> renamed;

    bool empty() const { return inOrder.empty() && renamed.empty(); }
};

struct PackReadOptions {
    Unit unit = Unit::millimeter;  ///< of the file, unless the file records its own
    /// `unit` as the caller set it; set by `readPack`, for a warning where the file records
    /// another.
    Unit requestedUnit = Unit::millimeter;
    PackColumns columns;
    double radius = 0;  ///< mm, of the spheres of a file without radii; 0: such a file is refused
    /// .vdb: the point grid; empty: the first one.
    std::string gridName;
    /// Bytes that the process may hold while it reads; 0: what it holds and what is free.
    double memoryLimit = 0;
    Callbacks callbacks{};  ///< warnings, where a file states what a pack cannot hold
};

/// Reads a pack of any program, in mm: x, y, z and radius (or diameter) by name, as `PackBuilder`
/// knows them, in any order and case; id, region, order, depth and contacts where there are; all
/// else as `columns`, in the numbers of the file. The format by prefix ("lammps:f.txt") or
/// extension:
///
/// - .vdb: a grid of points.
/// - .vtp, .vtu: ASCII, base64 or raw, plain or deflated; .pvtp, .pvtu: the pieces that they name;
///   .vtk: legacy polygon data and unstructured grids, text or binary. .vtkhdf: the points of
///   unstructured grids and polygon data. .ply: text or binary, either byte order.
/// - .csv, .tsv, .txt, .dat, .input: cells separated by commas, semicolons, tabs or blanks, the
///   columns named by the first line, by a comment (#) above it, or by `options.columns`.
/// - yade: x_y_z_r, with id, matId (as region), clumpId or attrs if the #format line says so; and
///   five columns without one, the last of which is the clump (SpherePack.save).
/// - .dat that begins with "Version 2.0": particle_input of MFiX. .restart: MercuryDPM. .geo:
///   GenGeo.
/// - .xyz: extended XYZ with a column radius, or plain with `options.columns` or `options.radius`;
///   of several frames the last one.
/// - .npz: numpy's savez or savez_compressed: arrays positions (N, 3) or x, y, z (N), and radii,
///   radius or diameters (N); others of N numbers or texts as the columns of their names.
/// - .data, lammps:, liggghts:, lammps-bonds: data files of LAMMPS and LIGGGHTS with atom style
///   sphere, granular or bpm/sphere, and of `writePack`. type, density, molecule and image flags
///   are kept, other sections left out.
/// - .dump, .lammpstrj, dump: their text dumps with a column radius or diameter; of several frames
///   the last one. x y z are taken, or else xs ys zs, xu yu zu or xsu ysu zsu.
///
/// LAMMPS files that name their units (si, cgs or micro) record their own unit; their densities
/// then are the column `density_kg_m3`. Periodic boxes become the pack's cell (LAMMPS, .xyz, YADE);
/// `callbacks` are warned of those that cannot: triclinic ones, and boxes without flags that
/// spheres leave.
///
/// Ids 0, 1, 2, ... come back as an empty `id`. Time and memory are
/// proportional to the size of the file; of deflated arrays (.vtp, .npz), to the sizes that it
/// states, which are compared with each other and with the limit on memory before any is inflated.
/// @throws IoError, InputError (with line or offset), ParameterError (unknown format),
/// ResourceError (not enough memory)
Pack<3> readPack(const std::string& file, const PackReadOptions& options = {});

/// Whether all spheres of a pack lie in one plane of constant z: three at the least.
bool isPlane(const Pack<3>& pack);
/// The same spheres as circles, where all lie at one height. @throws InputError otherwise.
Pack<2> asCircles(const Pack<3>& pack);

/// Writes a table (.csv) with one row per contact and the columns i, j, gap, nx, ny, nz, region_i,
/// region_j, and part_i, part_j of a pack of several parts. Whole or absent, as `writePack`.
///
/// i and j are ids as in the pack's file (indices if the pack has no ids). The normal points from i
/// to j and has length one, or is 0 0 0 if the centers coincide; 2D: nz = 0. Regions are 0 if the
/// pack has none. Numbers are read back as the same doubles.
///
/// @param contacts  as from `listContacts(pack.spheres, ...)`, written in their order.
/// @param file      any name; its prefix and extension are ignored.
/// @param unit      of `gap`, negative where the spheres overlap.
/// @throws ParameterError (a contact between spheres that the pack does not have, or without a
/// finite gap; attributes of the wrong length), IoError
template <int Dim>
void writeContacts(const Pack<Dim>& pack, const std::vector<Contact>& contacts,
                   const std::string& file, Unit unit = Unit::millimeter);

}  // namespace vdbpack
