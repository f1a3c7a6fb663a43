#include "vdbpack/domain/facet_bins.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

// Rings farther out than this are not told apart; a question starts there at the latest.
constexpr int kMostRings = 7;
constexpr std::size_t kAsked = 32;
constexpr std::size_t kFacetsPerChunk = 4096;
// A triangle lower than this share of its longest edge is taken as that edge: its normal has no
// digits left, and the place of its points changes by less than this share.
constexpr double kSliver = 1e-8;

template <int Dim>
struct Placed {
    std::size_t cell;
    std::uint32_t facet;
};

double nearestOnSegment(const Vec<3>& p, const Vec<3>& a, const Vec<3>& edge, Vec<3>& point) {
    const Vec<3> to = p - a;
    const double square = squaredLength(edge);
    const double t = square > 0 ? std::clamp(dot(to, edge) / square, 0.0, 1.0) : 0.0;
    const Vec<3> offset = edge * t;
    point = a + offset;
    return squaredLength(to - offset);
}

/// Squared distance of `x` to a facet and its nearest point; only right if below `best`, else
/// anything not below it.
double facetDistance(const Facet<2>& f, const Vec<2>& x, double, Vec<2>& point) {
    const Vec<2> to = x - f[0];
    const Vec<2> edge = f[1] - f[0];
    const double square = squaredLength(edge);
    const double t = square > 0 ? std::clamp(dot(to, edge) / square, 0.0, 1.0) : 0.0;
    const Vec<2> offset = edge * t;
    point = f[0] + offset;
    return squaredLength(to - offset);
}

double facetDistance(const Facet<3>& f, const Vec<3>& x, double best, Vec<3>& point) {
    const Vec<3> p = x - f[0];
    const Vec<3> ab = f[1] - f[0];
    const Vec<3> ac = f[2] - f[0];
    const Vec<3> n = cross(ab, ac);
    const double n2 = squaredLength(n);
    const double height = dot(n, p);
    // The plane is no farther than the triangle.
    if (height * height > best * n2) return std::numeric_limits<double>::infinity();
    // Inside the prism over the triangle where all three are positive (barycentric, times n2).
    const Vec<3> m = cross(p, n);
    const double sideAb = dot(ab, m);
    const double sideCa = -dot(ac, m);
    const double sideBc = n2 - sideAb - sideCa;
    if (n2 > 0 && sideAb >= 0 && sideCa >= 0 && sideBc >= 0) {
        point = x - n * (height / n2);
        return height * height / n2;
    }
    // The nearest point lies on an edge that `x` is beyond.
    double nearest = std::numeric_limits<double>::infinity();
    const auto tryEdge = [&](const Vec<3>& a, const Vec<3>& edge) {
        Vec<3> candidate;
        const double distance = nearestOnSegment(x, a, edge, candidate);
        if (distance < nearest) {
            nearest = distance;
            point = candidate;
        }
    };
    if (sideAb < 0 || n2 == 0) tryEdge(f[0], ab);
    if (sideCa < 0 || n2 == 0) tryEdge(f[0], ac);
    if (sideBc < 0 || n2 == 0) tryEdge(f[1], f[2] - f[1]);
    return nearest;
}

void simplifySliver(Facet<2>&) {}

void simplifySliver(Facet<3>& f) {
    int longest = 0;
    double square = 0;
    for (int i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double s = squaredLength(f[(k + 1) % 3] - f[k]);
        if (s > square) {
            square = s;
            longest = i;
        }
    }
    const Vec<3> n = cross(f[1] - f[0], f[2] - f[0]);
    if (squaredLength(n) > kSliver * kSliver * square * square) return;
    const auto k = static_cast<std::size_t>(longest);
    f = {f[k], f[(k + 1) % 3], f[(k + 1) % 3]};
}

Vec<2> facetNormal(const Facet<2>& f) {
    const Vec<2> edge = f[1] - f[0];
    return {{-edge[1], edge[0]}};
}

Vec<3> facetNormal(const Facet<3>& f) {
    return cross(f[1] - f[0], f[2] - f[0]);
}

/// Whether the projections of a triangle onto the planes of the axes meet those of a cube: with
/// the plane itself and the bounds these are all the axes that can separate the two.
bool edgesMeetCube(const Facet<3>& f, const Vec<3>& center, double half) {
    const Facet<3> t = {f[0] - center, f[1] - center, f[2] - center};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec<3> edge = t[(i + 1) % 3] - t[i];
        for (int axis = 0; axis < 3; ++axis) {
            // The separating direction edge x axis, written out in the other two components.
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            const double a = edge[v];
            const double b = -edge[u];
            const double first = a * t[i][u] + b * t[i][v];
            const double second = a * t[(i + 2) % 3][u] + b * t[(i + 2) % 3][v];
            const double reach = half * (std::abs(a) + std::abs(b));
            if (std::min(first, second) > reach || std::max(first, second) < -reach) return false;
        }
    }
    return true;
}

bool edgesMeetCube(const Facet<2>&, const Vec<2>&, double) {
    return true;
}

}  // namespace

template <int Dim>
FacetBins<Dim>::FacetBins(std::vector<Facet<Dim>> facets) : facets_(std::move(facets)) {
    for (auto& facet : facets_) {
        for (const auto& corner : facet) bounds_.add(corner);
        simplifySliver(facet);
    }
    if (facets_.empty()) return;
    origin_ = bounds_.center();

    // Cells as large as a common facet: a question then meets few cells and few facets in each.
    std::vector<double> extents;
    const std::size_t stride = facets_.size() / 4096 + 1;
    for (std::size_t i = 0; i < facets_.size(); i += stride) {
        Box<Dim> box;
        for (const auto& corner : facets_[i]) box.add(corner);
        const Vec<Dim> size = box.size();
        extents.push_back(*std::max_element(size.c.begin(), size.c.end()));
    }
    std::nth_element(extents.begin(), extents.begin() + static_cast<long>(extents.size() / 2),
                     extents.end());
    chooseCell(extents[extents.size() / 2]);
    while (!fill(24 * facets_.size() + 65536)) chooseCell(1.5 * cell_);
    markDistances();
}

template <int Dim>
void FacetBins<Dim>::chooseCell(double cell) {
    const Vec<Dim> size = bounds_.size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    const double mostCells = 8.0 * static_cast<double>(facets_.size()) + 32768;
    // At least so large that digits suffice to tell neighboring cells apart, and never zero.
    double largest = longest;
    for (int i = 0; i < Dim; ++i)
        largest = std::max({largest, std::abs(bounds_.lo[i]), std::abs(bounds_.hi[i])});
    cell_ = std::max({cell, longest * 1e-6, largest * 1e-9, 1e-150});
    const auto cellsAt = [&](double edge) {
        double product = 1;
        for (int i = 0; i < Dim; ++i) product *= std::floor(size[i] / edge) + 1;
        return product;
    };
    while (cellsAt(cell_) > mostCells) cell_ *= 1.1;
    inverse_ = 1 / cell_;
    for (int i = 0; i < Dim; ++i)
        count_[static_cast<std::size_t>(i)] = static_cast<int>(size[i] * inverse_) + 1;
}

/// Lists the cells that each facet meets, never one too few. @return false if that takes more
/// than `mostItems` entries.
template <int Dim>
bool FacetBins<Dim>::fill(std::size_t mostItems) {
    std::size_t cells = 1;
    for (const int n : count_) cells *= static_cast<std::size_t>(n);
    const std::size_t chunks = (facets_.size() + kFacetsPerChunk - 1) / kFacetsPerChunk;
    std::vector<std::vector<Placed<Dim>>> placed(chunks);
    std::atomic<std::size_t> total{0};

    const auto cellOf = [&](double coordinate, int axis) {
        const double index = std::floor((coordinate - bounds_.lo[axis]) * inverse_);
        const auto last = count_[static_cast<std::size_t>(axis)] - 1;
        return static_cast<int>(std::clamp(index, 0.0, static_cast<double>(last)));
    };
    const auto flat = [&](const Index& index) {
        std::size_t cell = 0;
        for (std::size_t i = static_cast<std::size_t>(Dim); i-- > 0;)
            cell = cell * static_cast<std::size_t>(count_[i]) + static_cast<std::size_t>(index[i]);
        return cell;
    };

    const auto place = [&](std::uint32_t id, std::vector<Placed<Dim>>& out) {
        const Facet<Dim>& f = facets_[id];
        Box<Dim> box;
        for (const auto& corner : f) box.add(corner);
        const Vec<Dim> size = box.size();
        const double extent = *std::max_element(size.c.begin(), size.c.end());
        // Rounding must not lose a cell; a facet too many does no harm.
        const double slack = 1e-7 * (cell_ + extent);
        Index lo, hi;
        std::size_t range = 1;
        for (int i = 0; i < Dim; ++i) {
            const auto k = static_cast<std::size_t>(i);
            lo[k] = cellOf(box.lo[i] - slack, i);
            hi[k] = cellOf(box.hi[i] + slack, i);
            range *= static_cast<std::size_t>(hi[k] - lo[k] + 1);
        }
        if (range == 1) {
            out.push_back({flat(lo), id});
            return;
        }
        const Vec<Dim> n = facetNormal(f);
        if (!(squaredLength(n) > 0)) {
            // A segment: the cells about pieces of it no longer than a cell.
            const Vec<Dim> edge = f[1] - f[0];
            const int pieces = static_cast<int>(extent * inverse_) + 1;
            std::vector<std::size_t> touched;
            for (int piece = 0; piece < pieces; ++piece) {
                const Vec<Dim> a = f[0] + edge * (static_cast<double>(piece) / pieces);
                const Vec<Dim> b = f[0] + edge * (static_cast<double>(piece + 1) / pieces);
                Index from, to;
                for (int i = 0; i < Dim; ++i) {
                    const auto k = static_cast<std::size_t>(i);
                    from[k] = cellOf(std::min(a[i], b[i]) - slack, i);
                    to[k] = cellOf(std::max(a[i], b[i]) + slack, i);
                }
                for (Index at = from;;) {
                    touched.push_back(flat(at));
                    std::size_t k = 0;
                    while (k < static_cast<std::size_t>(Dim) && ++at[k] > to[k]) {
                        at[k] = from[k];
                        ++k;
                    }
                    if (k == static_cast<std::size_t>(Dim)) break;
                }
            }
            std::sort(touched.begin(), touched.end());
            touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
            for (const std::size_t cell : touched) out.push_back({cell, id});
            return;
        }
        // Column by column along the axis that the facet faces most, so that the work is
        // proportional to the cells that are met even where the facet is huge.
        int w = 0;
        for (int i = 1; i < Dim; ++i)
            if (std::abs(n[i]) > std::abs(n[w])) w = i;
        const auto kw = static_cast<std::size_t>(w);
        double tilt = 0;
        for (int i = 0; i < Dim; ++i)
            if (i != w) tilt += std::abs(n[i] / n[w]);
        const double half = 0.5 * cell_ + slack;
        Index first = lo;
        Index last = hi;
        last[kw] = first[kw];
        for (Index at = first;;) {
            double middle = f[0][w];
            Vec<Dim> center;
            for (int i = 0; i < Dim; ++i) {
                if (i == w) continue;
                center[i] = bounds_.lo[i] + (at[static_cast<std::size_t>(i)] + 0.5) * cell_;
                middle -= n[i] / n[w] * (center[i] - f[0][i]);
            }
            const double spread = half * tilt + slack;
            Index cell = at;
            const int from = std::max(lo[kw], cellOf(middle - spread, w));
            const int to = std::min(hi[kw], cellOf(middle + spread, w));
            for (int level = from; level <= to; ++level) {
                cell[kw] = level;
                center[w] = bounds_.lo[w] + (level + 0.5) * cell_;
                if (range <= 8 || edgesMeetCube(f, center, half)) out.push_back({flat(cell), id});
            }
            std::size_t k = 0;
            while (k < static_cast<std::size_t>(Dim) && ++at[k] > last[k]) {
                at[k] = first[k];
                ++k;
            }
            if (k == static_cast<std::size_t>(Dim)) break;
            if (out.size() > mostItems) return;
        }
    };

    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chunks, 1),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t chunk = range.begin(); chunk != range.end(); ++chunk) {
                              const std::size_t begin = chunk * kFacetsPerChunk;
                              const std::size_t end =
                                  std::min(facets_.size(), begin + kFacetsPerChunk);
                              auto& out = placed[chunk];
                              std::size_t counted = 0;
                              for (std::size_t i = begin; i < end && total <= mostItems; ++i) {
                                  place(static_cast<std::uint32_t>(i), out);
                                  total += out.size() - counted;
                                  counted = out.size();
                              }
                          }
                      });
    if (total > mostItems) return false;

    // Facets stay in their order within each cell, whatever the threads did.
    start_.assign(cells + 1, 0);
    for (const auto& chunk : placed)
        for (const auto& p : chunk) ++start_[p.cell + 1];
    for (std::size_t i = 0; i < cells; ++i) start_[i + 1] += start_[i];
    const Vec<Dim> size = bounds_.size();
    // Rounding of a local coordinate to float, on both sides of a comparison.
    const double rounding = 3e-7 * length(size);
    std::vector<Item> balls(facets_.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, facets_.size(), kFacetsPerChunk),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i != range.end(); ++i) {
                              Box<Dim> box;
                              for (const auto& corner : facets_[i]) box.add(corner);
                              const Vec<Dim> center = box.center();
                              double square = 0;
                              for (const auto& corner : facets_[i])
                                  square = std::max(square, squaredLength(corner - center));
                              for (int k = 0; k < Dim; ++k)
                                  balls[i].center[static_cast<std::size_t>(k)] =
                                      static_cast<float>(center[k] - origin_[k]);
                              balls[i].radius =
                                  static_cast<float>(std::sqrt(square) * (1 + 1e-6) + rounding);
                              balls[i].facet = static_cast<std::uint32_t>(i);
                          }
                      });
    items_.resize(start_[cells]);
    for (const auto& chunk : placed)
        for (const auto& p : chunk) items_[start_[p.cell]++] = balls[p.facet];
    for (std::size_t i = cells; i > 0; --i) start_[i] = start_[i - 1];
    start_[0] = 0;
    return true;
}

/// How many rings of cells around each cell are empty: a chessboard distance, spread one axis
/// after the other and one ring at a time.
template <int Dim>
void FacetBins<Dim>::markDistances() {
    const std::size_t cells = start_.size() - 1;
    rings_.resize(cells);
    std::vector<std::uint8_t> covered(cells), next(cells);
    for (std::size_t i = 0; i < cells; ++i) {
        covered[i] = start_[i] != start_[i + 1];
        rings_[i] = covered[i] ? 0 : kMostRings;
    }
    const auto across = static_cast<std::size_t>(count_[0]);
    const std::size_t rows = cells / across;
    using Range = tbb::blocked_range<std::size_t>;
    for (std::uint8_t ring = 1; ring < kMostRings; ++ring) {
        tbb::parallel_for(Range(0, rows, 256), [&](const Range& range) {
            for (std::size_t row = range.begin(); row != range.end(); ++row) {
                const std::uint8_t* from = covered.data() + row * across;
                std::uint8_t* to = next.data() + row * across;
                for (std::size_t i = 0; i < across; ++i) to[i] = from[i];
                for (std::size_t i = 1; i < across; ++i)
                    to[i] = static_cast<std::uint8_t>(to[i] | from[i - 1]);
                for (std::size_t i = 0; i + 1 < across; ++i)
                    to[i] = static_cast<std::uint8_t>(to[i] | from[i + 1]);
            }
        });
        covered.swap(next);
        std::size_t step = 1;  // rows between neighbors along the axis
        for (int axis = 1; axis < Dim; ++axis) {
            const auto n = static_cast<std::size_t>(count_[static_cast<std::size_t>(axis)]);
            tbb::parallel_for(Range(0, rows, 256), [&](const Range& range) {
                for (std::size_t row = range.begin(); row != range.end(); ++row) {
                    const std::size_t at = row / step % n;
                    const std::uint8_t* from = covered.data() + row * across;
                    const std::uint8_t* below = at > 0 ? from - step * across : from;
                    const std::uint8_t* above = at + 1 < n ? from + step * across : from;
                    std::uint8_t* to = next.data() + row * across;
                    for (std::size_t i = 0; i < across; ++i)
                        to[i] = static_cast<std::uint8_t>(from[i] | below[i] | above[i]);
                }
            });
            covered.swap(next);
            step *= n;
        }
        bool changed = false;
        for (std::size_t i = 0; i < cells; ++i)
            if (covered[i] && rings_[i] == kMostRings) {
                rings_[i] = ring;
                changed = true;
            }
        if (!changed) break;
    }
}

template <int Dim>
template <typename FacetBins<Dim>::Want kWant, class Found>
bool FacetBins<Dim>::search(const Vec<Dim>& x, double reach, Found* found) const {
    if (!(reach > 0) || facets_.empty()) return false;
    Index home;
    Vec<Dim> within;  // place inside the home cell, mm from its lower corner
    double margin = cell_;
    bool onGrid = true;
    int ring = 0;
    int lastRing = 0;
    for (int i = 0; i < Dim; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double from = x[i] - bounds_.lo[i];
        if (!(from > -reach && x[i] - bounds_.hi[i] < reach)) return false;
        // Points far outside take the outermost index that still is a number of cells.
        const double index =
            std::clamp(std::floor(from * inverse_), -1e9, static_cast<double>(count_[k]) + 1e9);
        home[k] = static_cast<int>(index);
        within[i] = from - index * cell_;
        margin = std::min({margin, within[i], cell_ - within[i]});
        const int beyond = std::max({0, -home[k], home[k] - (count_[k] - 1)});
        onGrid = onGrid && beyond == 0;
        ring = std::max(ring, beyond);
        lastRing = std::max({lastRing, home[k], count_[k] - 1 - home[k]});
    }
    std::size_t stride[3] = {1, 0, 0};
    for (int i = 1; i < Dim; ++i)
        stride[i] =
            stride[i - 1] * static_cast<std::size_t>(count_[static_cast<std::size_t>(i - 1)]);
    if (onGrid) {
        std::size_t cell = 0;
        for (int i = 0; i < Dim; ++i)
            cell += stride[i] * static_cast<std::size_t>(home[static_cast<std::size_t>(i)]);
        ring = rings_[cell];
    }
    // Rounding of the home cell is far below this share of a cell.
    margin -= 1e-7 * cell_;

    std::array<std::uint32_t, kAsked> asked;
    asked.fill(std::numeric_limits<std::uint32_t>::max());
    double best = reach * reach;
    float bestLength = static_cast<float>(reach * (1 + 1e-6));
    std::array<float, static_cast<std::size_t>(Dim)> local;
    for (int i = 0; i < Dim; ++i)
        local[static_cast<std::size_t>(i)] = static_cast<float>(x[i] - origin_[i]);
    bool any = false;
    const auto axisSquare = [&](int axis, int offset) {
        if (offset == 0) return 0.0;
        double d = offset > 0 ? offset * cell_ - within[axis] : within[axis] - (offset + 1) * cell_;
        d -= 1e-7 * cell_;
        return d > 0 ? d * d : 0.0;
    };
    // Visits the cells lo..hi of one row; true once the answer is known.
    const auto visit = [&](std::size_t rowStart, double rowSquare, int offset) {
        if (rowSquare + axisSquare(0, offset) >= best) return false;
        const auto cell = rowStart + static_cast<std::size_t>(home[0] + offset);
        const std::uint32_t end = start_[cell + 1];
        for (std::uint32_t item = start_[cell]; item != end; ++item) {
            const Item& candidate = items_[item];
            float ballSquare = 0;
            for (std::size_t k = 0; k < static_cast<std::size_t>(Dim); ++k)
                ballSquare += (local[k] - candidate.center[k]) * (local[k] - candidate.center[k]);
            const float limit = bestLength + candidate.radius;
            if (ballSquare > limit * limit) continue;
            // A facet is listed in about four cells; look at it once.
            std::uint32_t& last = asked[candidate.facet % kAsked];
            if (last == candidate.facet) continue;
            last = candidate.facet;
            Vec<Dim> point;
            const double square = facetDistance(facets_[candidate.facet], x, best, point);
            if (!(square < best)) continue;
            any = true;
            if constexpr (kWant == Want::kAny) return true;
            if constexpr (kWant == Want::kAll) found->push_back({point, std::sqrt(square)});
            if constexpr (kWant == Want::kNearest) {
                best = square;
                bestLength = static_cast<float>(std::sqrt(square) * (1 + 1e-6));
                found->point = point;
            }
        }
        return false;
    };
    const auto visitRow = [&](std::size_t rowStart, double rowSquare, int outer, bool whole) {
        if (rowSquare >= best) return false;
        if (whole) {
            const int from = std::max(-outer, -home[0]);
            const int to = std::min(outer, count_[0] - 1 - home[0]);
            for (int offset = from; offset <= to; ++offset)
                if (visit(rowStart, rowSquare, offset)) return true;
            return false;
        }
        if (home[0] - outer >= 0 && home[0] - outer < count_[0])
            if (visit(rowStart, rowSquare, -outer)) return true;
        if (home[0] + outer >= 0 && home[0] + outer < count_[0])
            if (visit(rowStart, rowSquare, outer)) return true;
        return false;
    };

    for (; ring <= lastRing; ++ring) {
        if (ring > 0) {
            const double bound = (ring - 1) * cell_ + margin;
            if (bound > 0 && bound * bound >= best) break;
        }
        const int fromY = std::max(-ring, -home[1]);
        const int toY = std::min(ring, count_[1] - 1 - home[1]);
        if constexpr (Dim == 2) {
            for (int y = fromY; y <= toY; ++y)
                if (visitRow(stride[1] * static_cast<std::size_t>(home[1] + y), axisSquare(1, y),
                             ring, std::abs(y) == ring))
                    return true;
        } else {
            const int fromZ = std::max(-ring, -home[2]);
            const int toZ = std::min(ring, count_[2] - 1 - home[2]);
            for (int z = fromZ; z <= toZ; ++z) {
                const double squareZ = axisSquare(2, z);
                if (squareZ >= best) continue;
                const std::size_t plane = stride[2] * static_cast<std::size_t>(home[2] + z);
                for (int y = fromY; y <= toY; ++y)
                    if (visitRow(plane + stride[1] * static_cast<std::size_t>(home[1] + y),
                                 squareZ + axisSquare(1, y), ring,
                                 std::abs(y) == ring || std::abs(z) == ring))
                        return true;
            }
        }
    }
    if constexpr (kWant == Want::kNearest)
        if (any) found->distance = std::sqrt(best);
    return any;
}

template <int Dim>
bool FacetBins<Dim>::nearest(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) const {
    return search<Want::kNearest>(x, reach, &wall);
}

template <int Dim>
void FacetBins<Dim>::within(const Vec<Dim>& x, double reach,
                            std::vector<WallPoint<Dim>>& points) const {
    search<Want::kAll>(x, reach, &points);
}

template <int Dim>
bool FacetBins<Dim>::anyCloser(const Vec<Dim>& x, double reach) const {
    return search<Want::kAny, const void>(x, reach, nullptr);
}

template <int Dim>
std::size_t FacetBins<Dim>::memoryBytes() const {
    return facets_.capacity() * sizeof(Facet<Dim>) + start_.capacity() * sizeof(std::uint32_t) +
           items_.capacity() * sizeof(Item) + rings_.capacity();
}

template class FacetBins<2>;
template class FacetBins<3>;

}  // namespace vdbpack
