#include "vdbpack/pack/front/vacancy_search.h"

#include "vdbpack/core/depth_range.h"
#include "vdbpack/core/lanes.h"

#include <limits>

namespace vdbpack {

namespace {

/// Room that no center is left with, in wanted radii: more than 1, so that a search also ends where
/// the room is hardly less than the wanted radius, as along the middle of a thin bone.
constexpr double kMostRoom = 1.018;

/// Where other sizes begin, parts of a cell with corners that are this near are not halved, in
/// wanted radii.
constexpr double kSliver = 0.12, kJump = 1.1;

/// Edge of a cell of the bitmap, in wanted radii: finer ones cost more stamping, coarser ones
/// leave more cells to halve.
template <int Dim>
constexpr double kStep = Dim == 3 ? 0.65 : 0.47;

/// Sets the bits from `first` to `last` of a row, if there are any.
inline void cover(std::uint64_t* words, int first, int last) {
    if (first > last) return;
    const int firstWord = first >> 6, lastWord = last >> 6;
    const std::uint64_t head = ~std::uint64_t{0} << (first & 63);
    const std::uint64_t tail = ~std::uint64_t{0} >> (63 - (last & 63));
    if (firstWord == lastWord) {
        words[firstWord] |= head & tail;
        return;
    }
    words[firstWord] |= head;
    for (int w = firstWord + 1; w < lastWord; ++w) words[w] = ~std::uint64_t{0};
    words[lastWord] |= tail;
}

}  // namespace

template <int Dim>
void VacancySearch<Dim>::start(const BlockState<Dim>& state, bool centersOnly) {
    state_ = &state;
    centersOnly_ = centersOnly;
    step_ = kStep<Dim> * state.settings.meanRadius;
    steps_ = {1, 1, 1};
    for (int d = 0; d < Dim; ++d)
        steps_[static_cast<std::size_t>(d)] = std::max(
            1, static_cast<int>(std::ceil((state.search.hi[d] - state.search.lo[d]) / step_)));
    rowWords_ = (static_cast<std::size_t>(steps_[0]) + 63) / 64;
    covered_.assign(
        static_cast<std::size_t>(steps_[1]) * static_cast<std::size_t>(steps_[2]) * rowWords_, 0);
    stampSpheres();
    stampOutside();
    at_ = {0, 0, 0};
    openWord();
}

/// Marks the cells in which some sphere leaves no vacancy: a center with the most room allowed is
/// nowhere farther from its cell's center than half the diagonal.
template <int Dim>
void VacancySearch<Dim>::stampSpheres() {
    const double corner = 0.5 * step_ * std::sqrt(static_cast<double>(Dim));
    const double inverse = 1 / step_;
    const int most = steps_[0] - 1;
    const Float8 count = {0, 1, 2, 3, 4, 5, 6, 7};
    for (std::size_t i = 0; i < state_->spheres.size(); ++i) {
        const Sphere<Dim>& s = state_->spheres[i];
        const double mostRoom =
            kMostRoom * (state_->local ? state_->leastMeans[i] : state_->settings.meanRadius);
        // Less by more than floats are off by.
        const double reach = (s.radius + mostRoom - corner) * inverse * (1 - 1e-5) -
                             1e-6 * static_cast<double>(most + 1);
        if (reach <= 0) continue;
        // In steps, with cell i's center at i.
        Vec<3> c;
        for (int d = 0; d < Dim; ++d) c[d] = (s.center[d] - state_->search.lo[d]) * inverse - 0.5;
        if (c[0] + reach < 0 || c[0] - reach > most) continue;
        int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
        for (int d = 1; d < Dim; ++d) {
            from[d] = std::max(0, static_cast<int>(std::ceil(c[d] - reach)));
            to[d] = std::min(steps_[static_cast<std::size_t>(d)] - 1,
                             static_cast<int>(std::floor(c[d] + reach)));
        }
        const auto x = static_cast<float>(c[0]);
        for (int k = from[2]; k <= to[2]; ++k) {
            const auto layer = static_cast<float>(reach * reach - (k - c[2]) * (k - c[2]));
            for (int j = from[1]; j <= to[1]; j += static_cast<int>(kLanes)) {
                const Float8 dy = count + static_cast<float>(j - c[1]);
                const Float8 square = layer - dy * dy;
                Float8 half = squareRoot(larger(square, 0.0f));
                half = choose(square <= 0.0f, -1.0f, half);  // none of that row
                std::int32_t first[kLanes], last[kLanes];
                store(first, roundedUp(larger(x - half, 0.0f)));
                store(last, -roundedUp(-smaller(x + half, static_cast<float>(most))));
                std::uint64_t* words = row(j, k);
                const int rows = std::min(static_cast<int>(kLanes), to[1] - j + 1);
                for (int l = 0; l < rows; ++l, words += rowWords_) cover(words, first[l], last[l]);
            }
        }
    }
}

/// Whether a point, of this depth by the field, certainly lies less deep than `least`.
template <int Dim>
bool VacancySearch<Dim>::isShallower(const Vec<Dim>& x, double depth, double least) {
    const double error = state_->settings.fieldError;
    return depth < least - error ||
           (depth < least + error && state_->sampler->depthRange(x).most < least);
}

/// Marks what lies too far outside the domain, in bricks: one lookup decides most of them.
template <int Dim>
void VacancySearch<Dim>::stampOutside() {
    constexpr int kBrick = 8;
    for (int k = 0; k < steps_[2]; k += Dim == 3 ? kBrick : 1)
        for (int j = 0; j < steps_[1]; j += kBrick)
            for (int i = 0; i < steps_[0]; i += kBrick) stampOutside({i, j, k}, kBrick, 0);
}

/// Marks the cells of a brick that certainly lie too far outside; halves it where that is
/// undecided.
/// @param mostRoom  that a center in it may have, mm; 0: to be found.
template <int Dim>
void VacancySearch<Dim>::stampOutside(const std::array<int, 3>& at, int edge, double mostRoom) {
    int end[3];
    Vec<Dim> center = state_->search.lo + state_->origin;
    for (std::size_t d = 0; d < 3; ++d) {
        if (at[d] >= steps_[d]) return;
        end[d] = std::min(d < Dim ? at[d] + edge : 1, steps_[d]);
        if (d < Dim) center.c[d] += (at[d] + 0.5 * edge) * step_;
    }
    const std::uint64_t mask = ((std::uint64_t{1} << edge) - 1) << (at[0] & 63);
    std::uint64_t left = 0;
    for (int k = at[2]; k < end[2]; ++k)
        for (int j = at[1]; j < end[1]; ++j) left |= ~row(j, k)[at[0] >> 6] & mask;
    if (left == 0) return;
    const double corner = 0.5 * edge * step_ * std::sqrt(static_cast<double>(Dim));
    const double depth = -state_->sampler->signedDistance(center);
    if (mostRoom == 0) {
        // As deep as that, there is room enough for the largest everywhere in it.
        if (depth - state_->settings.fieldError > kMostRoom * state_->settings.maxRadius + corner)
            return;
        // The field ends soon outside; without a wall in it, all of the brick is there.
        if (depth < -state_->settings.fieldError && !state_->sampler->isWallCloser(center, corner))
            mostRoom = std::numeric_limits<double>::infinity();
        else
            mostRoom = kMostRoom * state_->leastMean(center - state_->origin, corner);
    }
    if (isShallower(center, depth, mostRoom - corner)) {
        for (int k = at[2]; k < end[2]; ++k)
            for (int j = at[1]; j < end[1]; ++j) row(j, k)[at[0] >> 6] |= mask;
    } else if (edge > 2 && isShallower(center, depth, mostRoom + corner)) {
        const int half = edge / 2;
        for (int child = 0; child < (1 << Dim); ++child) {
            std::array<int, 3> sub = at;
            for (std::size_t d = 0; d < Dim; ++d) sub[d] += child >> d & 1 ? half : 0;
            stampOutside(sub, half, mostRoom);
        }
    }
}

/// The cells of the word at `at_` that no sphere covers.
template <int Dim>
void VacancySearch<Dim>::openWord() {
    const int cells = std::min(64, steps_[0] - at_[0]);
    const std::uint64_t all = cells == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << cells) - 1;
    left_ = ~row(at_[1], at_[2])[at_[0] >> 6] & all;
}

/// Continues with the next word. @return false after the last one.
template <int Dim>
bool VacancySearch<Dim>::nextWord() {
    at_[0] += 64;
    if (at_[0] >= steps_[0]) at_[0] = 0, ++at_[1];
    if (at_[1] >= steps_[1]) at_[1] = 0, ++at_[2];
    if (at_[2] >= steps_[2]) return false;
    openWord();
    return true;
}

template <int Dim>
bool VacancySearch<Dim>::next(Vec<Dim>& vacancy) {
    const double corner = 0.5 * step_ * std::sqrt(static_cast<double>(Dim));
    do {
        for (; left_ != 0; skip()) {
            const int cell[3] = {at_[0] + __builtin_ctzll(left_), at_[1], at_[2]};
            Vec<Dim> c;
            for (int d = 0; d < Dim; ++d) c[d] = state_->search.lo[d] + (cell[d] + 0.5) * step_;
            const double own = state_->meanAt(c);
            wanted_ = state_->hasOneSize(c, 0.5 * step_) ? own : finestIn(c, step_, own);
            straddles_ = own > kJump * wanted_;
            const double mostRoom = kMostRoom * wanted_;
            const Vec<Dim> global = c + state_->origin;
            if (isShallower(global, -state_->sampler->signedDistance(global), mostRoom - corner))
                continue;
            nearby_.clear();
            const double reach = straddles_ ? kMostRoom * own : mostRoom;
            const double near = mostRoom - (centersOnly_ ? 0 : corner);
            const bool open = state_->cells.near(c, reach, [&](std::uint32_t i) {
                nearby_.push_back(i);
                return !covers(i, c, near);
            });
            if (open && findIn(c, centersOnly_ ? 0 : step_, vacancy)) return true;
        }
    } while (at_[2] < steps_[2] && nextWord());
    return false;
}

template <int Dim>
double VacancySearch<Dim>::finestIn(const Vec<Dim>& center, double edge, double own) const {
    double least = own;
    for (int d = 0; d < Dim && state_->local; ++d)
        for (const double side : {-0.5, 0.5}) {
            Vec<Dim> x = center;
            x[d] += side * edge;
            least = std::min(least, state_->meanAt(x));
        }
    return least;
}

/// Searches a cell for a vacancy, by halving; `nearby_` holds the spheres in reach.
template <int Dim>
bool VacancySearch<Dim>::findIn(const Vec<Dim>& center, double edge, Vec<Dim>& vacancy) {
    const double corner = 0.5 * edge * std::sqrt(static_cast<double>(Dim));
    const FrontSettings<Dim>& settings = state_->settings;
    DomainSampler<Dim>& sampler = *state_->sampler;
    const double own = straddles_ ? state_->meanAt(center) : wanted_;
    const double least = straddles_ ? finestIn(center, edge, own) : wanted_;
    const double mostRoom = kMostRoom * least;
    double room = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : nearby_) {
        if (covers(i, center, mostRoom - corner)) return false;
        const Sphere<Dim>& s = state_->spheres[i];
        room = std::min(room, length(s.center - center) - s.radius);
    }
    // The field alone would be too coarse: every cell along the wall would be halved to the end.
    const Vec<Dim> global = center + state_->origin;
    if (mostRoom > corner && sampler.isWallCloser(global, mostRoom - corner)) return false;
    // A vacancy is at least the wanted radius away from a center outside, more than the corner of
    // the cell: none is in it.
    const double outside = sampler.signedDistance(global);
    // Near the wall even the sign of the field can be wrong; the triangles decide.
    if (outside > settings.fieldError ||
        (outside > 0 && (settings.fieldError == 0 || !sampler.contains(global))))
        return false;
    if (room >= own && !sampler.isWallCloser(global, own)) {
        vacancy = center;
        // All of a ball that no wall crosses is on one side.
        return sampler.contains(global);
    }
    // Otherwise a center this close to a vacancy has the room itself, unless its sign is wrong.
    if (corner < 0.5 * (mostRoom - least)) return false;
    // Where other sizes begin, it has the room of the finer ones alone.
    if (own > kJump * least && corner < kSliver * least) return false;
    for (int child = 0; child < (1 << Dim); ++child) {
        Vec<Dim> c = center;
        for (int d = 0; d < Dim; ++d) c[d] += (child >> d & 1 ? 0.25 : -0.25) * edge;
        if (findIn(c, 0.5 * edge, vacancy)) return true;
    }
    return false;
}

template class VacancySearch<2>;
template class VacancySearch<3>;

}  // namespace vdbpack
