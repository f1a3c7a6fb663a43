// The relaxation in a periodic cell: images of the spheres that are near others across its faces.
//
// Images stand among the slots as spheres that do not move; after each step they are put to where
// the spheres are of which they are images.
#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/relaxation.h"

#include <limits>

namespace vdbpack {

template <int Dim>
Home Relaxation<Dim>::wrapped(Home home) const {
    for (std::size_t d = 0; d < Dim; ++d) {
        if (period_[d] == 0) continue;
        std::int64_t at = (home[d] - cellLow_[d]) % period_[d];
        if (at < 0) at += period_[d];
        home[d] = cellLow_[d] + at;
        // Where the period was rounded up.
        while (static_cast<double>(home[d]) * quantum_ >= cell_.box.hi[static_cast<int>(d)])
            --home[d];
    }
    return home;
}

template <int Dim>
void Relaxation<Dim>::addImages() {
    std::size_t own = 0;
    for (std::size_t i = 0; i < now_.labels.size(); ++i)
        if (now_.labels[i] != kOfOthers) now_.take(own++, now_, i);
    const double grow = static_cast<double>(listedGrow()) * (1 + 1e-6);
    const auto most = static_cast<double>(most_), further = static_cast<double>(further_);
    images_.clear();
    for (std::size_t i = 0; i < own; ++i) {
        Home& home = now_.homes[i];
        Body& body = now_.bodies[i];
        const Home inside = wrapped(home);
        if (inside != home) {
            const Body from = body;
            Body& before = now_.before[i];
            home = inside;
            body = {lowBits(home[0]), lowBits(home[1]), lowBits(home[2]), body.radius};
            before = {body.x + before.x - from.x, body.y + before.y - from.y,
                      body.z + before.z - from.z, before.radius};
            now_.listed[i] = {body.x, body.y, body.z, now_.listed[i].radius};
            // The walls around are known elsewhere.
            if (!isFixed(now_.labels[i])) now_.vicinities[i].roam = -1;
        }
        const auto radius = static_cast<double>(body.radius);
        double reach = (radius + most) * grow + static_cast<double>(listedGap());
        // Vacancies are sought near a slot, among all spheres around them.
        if (further > 0) reach = std::max(reach, radius + 2.2 * further + most);
        std::array<std::array<std::int64_t, 3>, 3> shifts{};
        std::array<std::size_t, 3> counts{1, 1, 1};
        for (std::size_t d = 0; d < Dim; ++d) {
            if (period_[d] == 0) continue;
            const auto above = static_cast<double>(home[d] - cellLow_[d]);
            const auto below = static_cast<double>(cellLow_[d] + period_[d] - home[d]);
            if (above < reach) shifts[d][counts[d]++] = period_[d];
            if (below < reach) shifts[d][counts[d]++] = -period_[d];
        }
        for (std::size_t n = 1; n < counts[0] * counts[1] * counts[2]; ++n)
            images_.push_back({0,
                               static_cast<std::uint32_t>(i),
                               {shifts[0][n % counts[0]], shifts[1][n / counts[0] % counts[1]],
                                shifts[2][n / counts[0] / counts[1]]}});
    }
    now_.resize(own + images_.size());
    for (std::size_t k = 0; k < images_.size(); ++k) {
        const Image& image = images_[k];
        Home& home = now_.homes[own + k];
        for (std::size_t d = 0; d < 3; ++d) home[d] = now_.homes[image.source][d] + image.shift[d];
        now_.bodies[own + k] = {lowBits(home[0]), lowBits(home[1]), lowBits(home[2]),
                                now_.bodies[image.source].radius};
        now_.before[own + k] = now_.bodies[own + k];
        now_.listed[own + k] = now_.bodies[own + k];
        now_.listed[own + k].radius = now_.listed[image.source].radius;
        now_.labels[own + k] = now_.places[own + k] = kOfOthers;
        now_.vicinities[own + k] = {};
        now_.vicinities[own + k].roam = std::numeric_limits<float>::infinity();
    }
}

template <int Dim>
void Relaxation<Dim>::findImages(const std::vector<std::uint32_t>& order) {
    std::vector<std::uint32_t> now(order.size());
    forAll(order.size(), [&](std::size_t to) { now[order[to]] = static_cast<std::uint32_t>(to); });
    const std::size_t own = order.size() - images_.size();
    for (std::size_t k = 0; k < images_.size(); ++k) {
        images_[k].slot = now[own + k];
        images_[k].source = now[images_[k].source];
    }
}

template <int Dim>
void Relaxation<Dim>::refreshImages() {
    forAll(images_.size(), [&](std::size_t k) {
        const Image& image = images_[k];
        const Body& body = now_.bodies[image.source];
        now_.bodies[image.slot] = {body.x + lowBits(image.shift[0]),
                                   body.y + lowBits(image.shift[1]),
                                   body.z + lowBits(image.shift[2]), body.radius};
    });
}

#define VDBPACK_INSTANTIATE(Dim)                                                  \
    template Home Relaxation<Dim>::wrapped(Home) const;                           \
    template void Relaxation<Dim>::addImages();                                   \
    template void Relaxation<Dim>::findImages(const std::vector<std::uint32_t>&); \
    template void Relaxation<Dim>::refreshImages();
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
