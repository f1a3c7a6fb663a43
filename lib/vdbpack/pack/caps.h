// Where a sphere that rolls on a pivot can rest: the vertices of forbidden caps.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// The caps that neighbors and walls forbid on the unit sphere (2D: circle) of directions from
/// a pivot, and the vertices that are left.
///
/// A candidate of radius r touching pivot p has its center at p + R n, R = r_p + r, |n| = 1.
/// A body forbids the directions with n.axis > height. Positions in contact with `Dim` bodies
/// are the points where `Dim` - 1 cap boundaries cross outside all other caps.
///
/// Computed in float, as a filter: directions carry errors of about 1e-5 and a vertex that lies
/// within that of another cap is kept. The caller polishes and decides in double.
template <int Dim>
class CapSet {
public:
    /// A direction where the candidate rests on two (2D: one) bodies besides the pivot.
    struct Vertex {
        std::array<float, Dim> direction;
        std::array<std::uint32_t, Dim - 1> bodies;  ///< as given to `add`
        /// Side of the plane through the bodies' axes (2D: of the axis): +1 or -1.
        float side;
    };

    void clear();
    /// Adds the cap n.axis > height of body `body`, before `findVertices`; one that forbids
    /// nothing is passed over. @return false if it forbids every direction: nothing rests anywhere.
    bool add(const std::array<float, Dim>& axis, float height, std::uint32_t body);
    std::size_t size() const { return count_; }

    /// All vertices left by the caps that were added, in a fixed order. The caps are sorted,
    /// largest first, in passing. @param vertices  is overwritten.
    void findVertices(std::vector<Vertex>& vertices);

    /// Adds one more cap after `findVertices` and updates its result: vertices inside the cap go,
    /// those on its boundary come. @return false if it forbids every direction.
    bool addLater(const std::array<float, Dim>& axis, float height, std::uint32_t body,
                  std::vector<Vertex>& vertices);

private:
    void pad();
    void sort();
    void findPairs(std::size_t i, std::size_t from);
    void keepLive(std::vector<Vertex>& vertices);

    std::size_t count_ = 0;  ///< in use; the arrays are longer
    std::array<std::vector<float>, Dim> axis_;
    std::vector<float> height_;
    std::vector<std::uint32_t> body_;
    std::vector<std::uint64_t> keys_;
    std::vector<float> scratch_;
    std::vector<std::uint32_t> bodyScratch_;
    /// Caps whose boundaries cross; in 2D the second of a pair is not used.
    std::vector<std::array<std::uint32_t, 2>> pairs_;
    std::size_t pairCount_ = 0;
};

extern template class CapSet<2>;
extern template class CapSet<3>;

}  // namespace vdbpack
