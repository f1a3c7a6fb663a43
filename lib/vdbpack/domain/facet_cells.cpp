#include "vdbpack/domain/facet_cells.h"

namespace vdbpack {

namespace {

/// Steps to the next index of the range `lo` to `hi`, the first axis fastest. @return false past
/// the last.
template <class Index>
bool advance(Index& at, const Index& lo, const Index& hi) {
    for (std::size_t k = 0; k < at.size(); ++k) {
        if (++at[k] <= hi[k]) return true;
        at[k] = lo[k];
    }
    return false;
}

/// Whether no axis (edge of the triangle) x (axis of space) separates the triangle from a cube.
/// Together with the triangle's plane and its bounds these are all axes that can separate the two.
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

/// Finds the cells that one facet meets.
template <int Dim>
class FacetRaster {
public:
    FacetRaster(const FacetCells<Dim>& cells, const Facet<Dim>& facet, std::uint32_t id,
                std::vector<FacetEntry>& entries)
        : cells_(cells), facet_(facet), id_(id), entries_(entries) {
        const Box<Dim> box = facetBox(facet);
        const Vec<Dim> size = box.size();
        extent_ = *std::max_element(size.c.begin(), size.c.end());
        slack_ = 1e-7 * (cells.edge + extent_);
        rangeOf(box.lo, box.hi, lo_, hi_);
        for (std::size_t k = 0; k < lo_.size(); ++k)
            range_ *= static_cast<std::size_t>(hi_[k] - lo_[k] + 1);
    }

    void list(std::size_t most) {
        if (range_ == 1) {
            entries_.push_back({cells_.flat(lo_), id_});
            return;
        }
        const Vec<Dim> normal = facetNormal(facet_);
        if (squaredLength(normal) > 0)
            listColumns(normal, most);
        else
            listSegment();
    }

private:
    using Index = typename FacetCells<Dim>::Index;

    /// The cells that a box meets. Rounding must not lose a cell, hence the slack.
    void rangeOf(const Vec<Dim>& low, const Vec<Dim>& high, Index& lo, Index& hi) const {
        for (int i = 0; i < Dim; ++i) {
            const auto k = static_cast<std::size_t>(i);
            lo[k] = cells_.along(low[i] - slack_, i);
            hi[k] = cells_.along(high[i] + slack_, i);
        }
    }

    /// A facet without area: the cells around pieces of it that are no longer than a cell.
    void listSegment() {
        const Vec<Dim> edge = facet_[1] - facet_[0];
        const int pieces = static_cast<int>(extent_ * cells_.inverse) + 1;
        std::vector<std::uint32_t> touched;
        for (int piece = 0; piece < pieces; ++piece) {
            Box<Dim> box;
            box.add(facet_[0] + edge * (static_cast<double>(piece) / pieces));
            box.add(facet_[0] + edge * (static_cast<double>(piece + 1) / pieces));
            Index from, to;
            rangeOf(box.lo, box.hi, from, to);
            Index at = from;
            do touched.push_back(cells_.flat(at));
            while (advance(at, from, to));
        }
        std::sort(touched.begin(), touched.end());
        touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
        for (const std::uint32_t cell : touched) entries_.push_back({cell, id_});
    }

    /// Column by column along the axis that the facet faces most, so that the work is proportional
    /// to the cells that are met even where the facet is huge.
    void listColumns(const Vec<Dim>& n, std::size_t most) {
        int w = 0;
        for (int i = 1; i < Dim; ++i)
            if (std::abs(n[i]) > std::abs(n[w])) w = i;
        const auto kw = static_cast<std::size_t>(w);
        double tilt = 0;
        for (int i = 0; i < Dim; ++i)
            if (i != w) tilt += std::abs(n[i] / n[w]);
        const double half = 0.5 * cells_.edge + slack_;
        const double spread = half * tilt + slack_;
        Index last = hi_;
        last[kw] = lo_[kw];
        Index at = lo_;
        do {
            // Where the plane of the facet crosses the middle of the column.
            double middle = facet_[0][w];
            Vec<Dim> center;
            for (int i = 0; i < Dim; ++i) {
                if (i == w) continue;
                center[i] =
                    cells_.bounds.lo[i] + (at[static_cast<std::size_t>(i)] + 0.5) * cells_.edge;
                middle -= n[i] / n[w] * (center[i] - facet_[0][i]);
            }
            Index cell = at;
            const int from = std::max(lo_[kw], cells_.along(middle - spread, w));
            const int to = std::min(hi_[kw], cells_.along(middle + spread, w));
            for (int level = from; level <= to; ++level) {
                cell[kw] = level;
                center[w] = cells_.bounds.lo[w] + (level + 0.5) * cells_.edge;
                if (range_ <= 8 || edgesMeetCube(facet_, center, half))
                    entries_.push_back({cells_.flat(cell), id_});
            }
        } while (advance(at, lo_, last) && entries_.size() <= most);
    }

    const FacetCells<Dim>& cells_;
    const Facet<Dim>& facet_;
    std::uint32_t id_;
    std::vector<FacetEntry>& entries_;
    double extent_;          // longest side of the facet's bounds, mm
    double slack_;           // mm
    Index lo_, hi_;          // cells that the bounds of the facet meet
    std::size_t range_ = 1;  // their number
};

}  // namespace

template <int Dim>
void FacetCells<Dim>::setEdge(double wanted, std::size_t facets) {
    const Vec<Dim> size = bounds.size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    const double mostCells = 8.0 * static_cast<double>(facets) + 32768;
    // Large enough that rounding cannot confuse neighboring cells, and never zero.
    double largest = longest;
    for (int i = 0; i < Dim; ++i)
        largest = std::max({largest, std::abs(bounds.lo[i]), std::abs(bounds.hi[i])});
    edge = std::max({wanted, longest * 1e-6, largest * 1e-9, 1e-150});
    const auto cellsAt = [&](double length) {
        double product = 1;
        for (int i = 0; i < Dim; ++i) product *= std::floor(size[i] / length) + 1;
        return product;
    };
    while (cellsAt(edge) > mostCells) edge *= 1.1;
    inverse = 1 / edge;
    for (int i = 0; i < Dim; ++i)
        count[static_cast<std::size_t>(i)] = static_cast<int>(size[i] * inverse) + 1;
}

template <int Dim>
void listCells(const FacetCells<Dim>& cells, const Facet<Dim>& facet, std::uint32_t id,
               std::size_t most, std::vector<FacetEntry>& entries) {
    FacetRaster<Dim>(cells, facet, id, entries).list(most);
}

template struct FacetCells<2>;
template struct FacetCells<3>;
template void listCells(const FacetCells<2>&, const Facet<2>&, std::uint32_t, std::size_t,
                        std::vector<FacetEntry>&);
template void listCells(const FacetCells<3>&, const Facet<3>&, std::uint32_t, std::size_t,
                        std::vector<FacetEntry>&);

}  // namespace vdbpack
