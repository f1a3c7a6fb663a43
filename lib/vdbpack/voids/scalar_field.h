// Numbers that vary in space, such as BV/TV or the thickness of the shell.
#pragma once

#include "vdbpack/core/box.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// A field of numbers.
class ScalarField {
public:
    virtual ~ScalarField() = default;
    /// The box that the field covers, mm; infinite along z for a field of the plane.
    virtual Box<3> bounds() const = 0;
    /// The value at `x` (mm), between `least()` and `most()`. Beyond the data, the value of the
    /// nearest data. Thread-safe.
    virtual double at(const Vec<3>& x) const = 0;
    /// A point of the data, mm, and a step that resolves them, mm: for a copy on a lattice.
    virtual std::pair<Vec<3>, double> lattice() const = 0;
    /// The smallest and the largest value of the file.
    double least() const { return least_; }
    double most() const { return most_; }

protected:
    double least_ = 0, most_ = 0;
};

/// What the numbers of a field mean.
struct ScalarMeaning {
    std::string name;                  ///< for messages, such as "BV/TV"
    std::vector<std::string> columns;  ///< names that the column of a table may have
    /// What is wrong with a finite value; empty: nothing.
    std::function<std::string(double)> fault;
};

/// Whether a file is a field of numbers by its name: .vdb, .csv, .tsv or .txt.
bool namesScalarField(const std::string& file);

/// Reads a field from a .vdb file or a table (.csv, .tsv, .txt).
///
/// Tables have columns x,y,z and one of `meaning.columns`, in any order; points may lie anywhere.
/// Where they are all nodes of a lattice, its planes evenly spaced or not, values are linear along
/// each axis in between, and beyond the lattice as at its border; else they are interpolated as for
/// `readDirectionField`, within the values of the points. The box that they cover follows as there.
/// A table without z is a field of the plane.
///
/// Of a .vdb file the first grid of floats or doubles counts, under any linear transform. The value
/// is linear between the centers of the active voxels; inactive ones have no value, whatever the
/// background. The field covers the box around the active voxels, grown by one voxel.
///
/// @param scale  mm in one unit of the file, > 0.
/// @throws InputError with the line or voxel if a value is not finite or faulty, or if columns,
///         grid or all values are missing
/// @throws ParameterError for files of other types, IoError, ResourceError
///
/// Cost: as for `readDirectionField`.
std::shared_ptr<const ScalarField> readScalarField(const std::string& file,
                                                   const ScalarMeaning& meaning, double scale = 1);

/// The same as a function of the points of a domain. The field must cover it.
/// @param bounds       of the domain, mm.
/// @param sliceHeight  2D: height of the plane in the field, mm.
/// @throws InputError with both boxes if the field does not cover `bounds`.
template <int Dim>
std::function<double(const Vec<Dim>&)> valuesOver(std::shared_ptr<const ScalarField> field,
                                                  const std::string& file,
                                                  const ScalarMeaning& meaning,
                                                  const Box<Dim>& bounds, double sliceHeight);

}  // namespace vdbpack
