// A set of spheres with what is known about each of them.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// A further column of a pack file (material, clump, ...), kept and written again.
/// Numbers are in `numbers`; a column with any cell that is not a number is in `texts`.
struct Column {
    std::string name;
    std::vector<double> numbers;     ///< one a sphere, or empty
    std::vector<std::string> texts;  ///< one a sphere, or empty
    /// Of what the numbers 0, 1, 2, ... stand for, such as parts; empty: they have none.
    std::vector<std::string> names{};
};

/// What is known about each sphere of a pack.
///
/// Every attribute is either empty or has one value a sphere, in the order of the spheres.
struct PackAttributes {
    std::vector<std::int64_t> id;        ///< name of the sphere in files; empty: its index
    std::vector<std::int32_t> region;    ///< 0 cortical, 1 trabecular
    std::vector<std::int64_t> order;     ///< when the sphere was placed, counted from 0
    std::vector<float> depth;            ///< distance of the center to the wall, mm
    std::vector<std::int32_t> contacts;  ///< touching spheres and walls
    std::vector<Column> columns;         ///< whatever else the file held
};

/// What the file of a pack states about how it was made.
struct PackOrigin {
    std::string axes{};             ///< of a patient: LPS or RAS; empty: none are stated
    double contactTolerance = 0;    ///< with which its contacts were counted; 0: it is not stated
    double interfaceTolerance = 0;  ///< between parts; 0: the same
    double shearRatio = 0;          ///< k_t / k_n of its bonds; 0: it is not stated
};

/// Spheres (2D: circles) in mm.
template <int Dim>
struct Pack : PackAttributes {
    std::vector<Sphere<Dim>> spheres;
    double sliceHeight = 0;    ///< 2D: the z written for every circle, mm
    PeriodicCell<Dim> cell{};  ///< in which they repeat; by default they do not
    PackOrigin origin{};
};

/// Calls `visit(name, values)` for each attribute but the id, empty or not, in the order in which
/// files list them. The only list of the attributes: what handles all of them goes through here.
///
/// @param attributes  a `Pack` or `PackAttributes`, const or not.
/// @param visit       takes a `std::string_view` and a vector of any of the types above: floats
///                    are lengths in mm, doubles and strings are further columns (of each, both
///                    vectors are visited).
template <class Attributes, class Visit>
void forEachAttributeButId(Attributes& attributes, const Visit& visit) {
    visit(std::string_view("region"), attributes.region);
    visit(std::string_view("order"), attributes.order);
    visit(std::string_view("depth"), attributes.depth);
    visit(std::string_view("contacts"), attributes.contacts);
    for (auto& column : attributes.columns) {
        visit(std::string_view(column.name), column.numbers);
        visit(std::string_view(column.name), column.texts);
    }
}

/// The same for all attributes, the id first.
template <class Attributes, class Visit>
void forEachAttribute(Attributes& attributes, const Visit& visit) {
    visit(std::string_view("id"), attributes.id);
    forEachAttributeButId(attributes, visit);
}

}  // namespace vdbpack
