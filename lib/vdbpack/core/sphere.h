// Spheres (2D: circles) and what differs between the plane and space.
#pragma once

#include "vdbpack/core/vec.h"

namespace vdbpack {

inline constexpr double kPi = 3.14159265358979323846;

/// A sphere (2D: circle); center and radius in mm.
template <int Dim>
struct Sphere {
    Vec<Dim> center;
    double radius = 0;

    friend bool operator==(const Sphere& a, const Sphere& b) {
        return a.center == b.center && a.radius == b.radius;
    }
};

/// What truly differs between 2D and 3D: the size of a ball and the words for it.
template <int Dim>
struct Measure;

template <>
struct Measure<2> {
    /// Area of a disc of radius `r`, mm².
    static constexpr double ball(double r) { return kPi * r * r; }
    static constexpr const char* kSphere = "circle";
    static constexpr const char* kSpheres = "circles";
    static constexpr const char* kVolume = "area";
    static constexpr const char* kVolumeUnit = "mm²";
};

template <>
struct Measure<3> {
    /// Volume of a ball of radius `r`, mm³.
    static constexpr double ball(double r) { return 4.0 / 3.0 * kPi * r * r * r; }
    static constexpr const char* kSphere = "sphere";
    static constexpr const char* kSpheres = "spheres";
    static constexpr const char* kVolume = "volume";
    static constexpr const char* kVolumeUnit = "mm³";
};

/// An order of spheres by their values: the last coordinate first, at one center by radius. Of a
/// pair in two parts of a pack, it says in which the pair counts.
template <int Dim>
bool isBefore(const Sphere<Dim>& a, const Sphere<Dim>& b) {
    for (int d = Dim - 1; d >= 0; --d)
        if (a.center[d] != b.center[d]) return a.center[d] < b.center[d];
    return a.radius < b.radius;
}

/// Surface-to-surface distance of two spheres, mm; negative where they overlap.
template <int Dim>
double gap(const Sphere<Dim>& a, const Sphere<Dim>& b) {
    return length(a.center - b.center) - (a.radius + b.radius);
}

}  // namespace vdbpack
