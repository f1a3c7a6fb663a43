// Generalized winding number: inside and outside also for surfaces with holes and overlaps.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// The generalized winding number of an oriented triangle soup: the solid angle of the surface seen
/// from a point, divided by 4 pi, positive where its back is seen.
///
/// A closed surface that faces outward gives 1 inside and 0 outside; where two overlap the number
/// is 2; inside a surface that faces inward it is -1. Next to holes it changes smoothly from one
/// side to the other, and 1/2 is the natural position of the missing wall.
///
/// Near triangles are computed exactly (Van Oosterom and Strackee 1983,
/// doi:10.1109/TBME.1983.325207), clusters that are far compared with their size by their first
/// three moments (Barill et al. 2018, doi:10.1145/3197517.3201337). Error below 0.02 in tests,
/// 0.003 on average. Immutable; may be shared between threads.
///
/// Cost: 200 bytes per triangle, a few microseconds per query.
class WindingNumber {
public:
    /// @param mesh  the normal of a triangle follows from the order of its vertices.
    explicit WindingNumber(const TriangleMesh& mesh);

    double operator()(const Vec<3>& x) const;

private:
    struct Triangle {
        Vec<3> a, b, c;  // about origin_
    };
    /// A group of neighboring triangles, or of two clusters.
    struct Cluster {
        Vec<3> center;     // weighted by area
        double reach = 0;  // largest distance of a corner from `center`
        // The parts of the moments of n A about `center` that the winding number needs: the sum; of
        // the first moment the trace and the symmetric part; of the second the contractions and the
        // symmetric part.
        Vec<3> area;
        double trace = 0;
        std::array<double, 6> first{};  // xx yy zz xy yz zx
        Vec<3> contracted;
        std::array<double, 10> second{};   // in the order of kSecond in winding_number.cpp
        std::uint32_t begin = 0, end = 0;  // of triangles_
        std::uint32_t children = 0;        // first of two neighbors; 0: none
    };
    void build(std::uint32_t cluster);
    void summarize(Cluster& cluster) const;

    Vec<3> origin_;
    std::vector<Triangle> triangles_;
    std::vector<Cluster> clusters_;
};

}  // namespace vdbpack
