#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/pack/front/touching.h"

DIM_TEST_CASE("a center is moved to where it touches spheres and planes") {
    RandomStream random(17, Dim);
    int flat = 0;
    for (int round = 0; round < 500; ++round) {
        // Contacts made for a known center, and a start a little off it.
        Vec<Dim> truth;
        for (int d = 0; d < Dim; ++d) truth[d] = 4 * random.uniform() - 2;
        std::array<Contact<Dim>, Dim> contacts;
        for (int k = 0; k < Dim; ++k) {
            auto& contact = contacts[static_cast<std::size_t>(k)];
            // Well apart: near the axes.
            Vec<Dim> away;
            for (int d = 0; d < Dim; ++d) away[d] = 0.6 * random.uniform() - 0.3;
            away[k] += 1;
            away = normalized(away);
            contact.distance = 1 + random.uniform();
            contact.flat = random.uniform() < 0.5;
            contact.at = truth - away * contact.distance;
            if (contact.flat) {
                ++flat;
                contact.normal = away;
                // Any point of the plane will do.
                Vec<Dim> along;
                for (int d = 0; d < Dim; ++d) along[d] = random.uniform();
                contact.at += along - away * dot(along, away);
            }
        }
        Vec<Dim> center = truth;
        for (int d = 0; d < Dim; ++d) center[d] += 0.02 * (random.uniform() - 0.5);
        REQUIRE(moveToTouch<Dim>(contacts, 1e-7, 1, center));
        for (const auto& c : contacts) {
            const double now = c.flat ? dot(center - c.at, c.normal) : length(center - c.at);
            CHECK(now == Approx(c.distance).margin(1e-9));
        }
    }
    CHECK(flat > 300);
    // Parallel planes have no such place, nor has one that is too far.
    std::array<Contact<Dim>, Dim> contacts;
    for (auto& c : contacts) {
        c.flat = true;
        c.normal[0] = 1;
        for (int d = 1; d < Dim; ++d) c.normal[d] = 0;
        c.distance = 1;
    }
    Vec<Dim> center{};
    CHECK_FALSE(moveToTouch<Dim>(contacts, 1e-7, 1, center));
    for (int k = 0; k < Dim; ++k) {
        contacts[static_cast<std::size_t>(k)].normal = Vec<Dim>{};
        contacts[static_cast<std::size_t>(k)].normal[k] = 1;
        contacts[static_cast<std::size_t>(k)].distance = 50;
    }
    CHECK_FALSE(moveToTouch<Dim>(contacts, 1e-7, 1, center));
}
