#include "vdbpack/measure/space_shares.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// The divisor of `n` next to its square root, from below.
std::size_t divisorOf(std::size_t n) {
    auto d = static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
    while (n % d != 0) --d;
    return d;
}

}  // namespace

template <int Dim>
SpaceShares<Dim>::SpaceShares(Ranks& ranks, const std::vector<Sphere<Dim>>& spheres,
                              const std::vector<std::int64_t>& rows, const Near& near,
                              const std::vector<float>* depth, std::uint64_t perPart)
    : ranks_(ranks), spheres_(spheres), rows_(rows), depth_(depth), near_(near) {
    for (const Sphere<Dim>& s : spheres) {
        bounds_.add(s.center);
        largest_ = std::max(largest_, s.radius);
    }
    largest_ = maxOver(&ranks, largest_);
    for (int d = 0; d < Dim; ++d) {
        bounds_.lo[d] = minOver(&ranks, bounds_.lo[d]);
        bounds_.hi[d] = maxOver(&ranks, bounds_.hi[d]);
    }
    const auto each = static_cast<std::size_t>(ranks.count());
    const std::uint64_t total = sumOver(&ranks, std::uint64_t{spheres.size()});
    rounds_ = static_cast<std::size_t>(1 + total / (perPart * each));
    cells_[0] = rounds_;
    cells_[1] = Dim == 3 ? divisorOf(each) : each;
    if constexpr (Dim == 3) cells_[2] = each / cells_[1];
}

template <int Dim>
std::size_t SpaceShares<Dim>::cellAt(double x, int axis) const {
    const std::size_t cells = cells_[static_cast<std::size_t>(axis)];
    const double at = (x - bounds_.lo[axis]) / (bounds_.hi[axis] - bounds_.lo[axis]);
    // Rises with x, so that a range of positions is a range of cells whatever the rounding.
    if (!(at > 0)) return 0;
    return std::min(cells - 1,
                    static_cast<std::size_t>(std::min(at, 1.0) * static_cast<double>(cells)));
}

/// Adds a sphere, or an image of one, to the lists of the ranks in whose parts of a round it is.
template <int Dim>
void SpaceShares<Dim>::send(std::size_t round, std::size_t i, const Vec<Dim>& shift, bool hasImages,
                            Lists& own, Lists& near) {
    const Sphere<Dim>& s = spheres_[i];
    const double reach = reachOf(s);
    const Sphere<Dim> image{s.center + shift, s.radius};
    const Vec<Dim>& x = image.center;
    if (cellAt(x[0] - reach, 0) > round || cellAt(x[0] + reach, 0) < round) return;
    const bool isOwn = cellAt(x[0], 0) == round && squaredLength(shift) == 0;
    bool shared = hasImages || cellAt(x[0] - reach, 0) != cellAt(x[0] + reach, 0);
    std::array<std::size_t, 3> first{}, at{}, last{};
    for (int d = 1; d < Dim; ++d) {
        const auto k = static_cast<std::size_t>(d);
        first[k] = cellAt(x[d] - reach, d);
        at[k] = cellAt(x[d], d);
        last[k] = cellAt(x[d] + reach, d);
        shared = shared || first[k] != last[k];
    }
    for (std::size_t z = first[2]; z <= last[2]; ++z)
        for (std::size_t y = first[1]; y <= last[1]; ++y) {
            const std::size_t to = z * cells_[1] + y;
            const bool isHome = isOwn && y == at[1] && z == at[2];
            (isHome ? own : near)[to].push_back(
                {image, rows_[i], shared, depth_ ? (*depth_)[i] : 0});
            if (isHome) sent_[to].push_back(i);
        }
}

/// How far from a sphere's center others are near it, mm.
template <int Dim>
double SpaceShares<Dim>::reachOf(const Sphere<Dim>& s) const {
    return std::max(s.radius * (1 + near_.slack) + largest_, near_.reach) * (1 + 1e-9);
}

template <int Dim>
auto SpaceShares<Dim>::part(std::size_t round) -> Part {
    const auto each = static_cast<std::size_t>(ranks_.count());
    Lists own(each), near(each);
    sent_.assign(each, {});
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
        const Vec<Dim>& x = spheres_[i].center;
        const Box<Dim> about = Box<Dim>{x, x}.grown(reachOf(spheres_[i]));
        int images = 0;
        near_.cell.forEachShift(about, bounds_, [&](const Vec<Dim>&) { ++images; });
        near_.cell.forEachShift(about, bounds_, [&](const Vec<Dim>& shift) {
            send(round, i, shift, images > 1, own, near);
        });
    }
    Part part;
    received_.clear();
    const auto append = [&part](const std::vector<Sent>& list) {
        for (const Sent& sent : list) {
            part.spheres.push_back(sent.sphere);
            part.rows.push_back(sent.row);
            part.shared.push_back(sent.shared != 0);
        }
    };
    for (const auto& list : exchanged(ranks_, std::move(own))) {
        append(list);
        received_.push_back(list.size());
        for (const Sent& sent : list)
            if (depth_) part.depth.push_back(sent.depth);
    }
    part.own = part.spheres.size();
    for (const auto& list : exchanged(ranks_, std::move(near))) append(list);
    return part;
}

template <int Dim>
void SpaceShares<Dim>::handBack(const std::vector<std::int32_t>& found,
                                std::vector<std::int32_t>& numbers) {
    std::vector<std::vector<std::int32_t>> replies;
    auto next = found.begin();
    for (const std::size_t count : received_) {
        const auto end = next + static_cast<std::ptrdiff_t>(count);
        replies.emplace_back(next, end);
        next = end;
    }
    const auto answers = exchanged(ranks_, std::move(replies));
    for (std::size_t r = 0; r < answers.size(); ++r)
        for (std::size_t k = 0; k < answers[r].size(); ++k) numbers[sent_[r][k]] = answers[r][k];
}

template class SpaceShares<2>;
template class SpaceShares<3>;

}  // namespace vdbpack
