#include "vdbpack/core/rng.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/pack/caps.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace vdbpack;

namespace {

template <int Dim>
struct Cap {
    Vec<Dim> axis;
    double height;
};

template <int Dim>
std::vector<Cap<Dim>> randomCaps(RandomStream& random, int count) {
    std::vector<Cap<Dim>> caps;
    while (static_cast<int>(caps.size()) < count) {
        Vec<Dim> v;
        for (int d = 0; d < Dim; ++d) v[d] = 2 * random.uniform() - 1;
        const double l = length(v);
        if (l > 1 || l < 0.1) continue;
        caps.push_back({v * (1 / l), 0.3 + 0.65 * random.uniform()});
    }
    return caps;
}

/// Every vertex by the plain definition, in double.
std::vector<Vec<3>> bruteForce(const std::vector<Cap<3>>& caps, double slack) {
    std::vector<Vec<3>> found;
    for (std::size_t i = 0; i < caps.size(); ++i)
        for (std::size_t j = i + 1; j < caps.size(); ++j) {
            const double c = dot(caps[i].axis, caps[j].axis);
            const double d = 1 - c * c;
            if (d < 1e-4) continue;
            const double a = (caps[i].height - caps[j].height * c) / d;
            const double b = (caps[j].height - caps[i].height * c) / d;
            const double square = (1 - a * caps[i].height - b * caps[j].height) / d;
            if (square <= 0) continue;
            for (const double sign : {-1.0, 1.0}) {
                const Vec<3> n = caps[i].axis * a + caps[j].axis * b +
                                 cross(caps[i].axis, caps[j].axis) * (sign * std::sqrt(square));
                bool live = true;
                for (std::size_t k = 0; live && k < caps.size(); ++k)
                    live = k == i || k == j || dot(n, caps[k].axis) <= caps[k].height + slack;
                if (live) found.push_back(n);
            }
        }
    return found;
}

std::vector<Vec<2>> bruteForce(const std::vector<Cap<2>>& caps, double slack) {
    std::vector<Vec<2>> found;
    for (std::size_t i = 0; i < caps.size(); ++i) {
        const double out = std::sqrt(1 - caps[i].height * caps[i].height);
        for (const double sign : {-1.0, 1.0}) {
            const Vec<2> side{{-caps[i].axis[1], caps[i].axis[0]}};
            const Vec<2> n = caps[i].axis * caps[i].height + side * (sign * out);
            bool live = true;
            for (std::size_t k = 0; live && k < caps.size(); ++k)
                live = k == i || dot(n, caps[k].axis) <= caps[k].height + slack;
            if (live) found.push_back(n);
        }
    }
    return found;
}

template <int Dim>
bool holds(const std::vector<Vec<Dim>>& all, const Vec<Dim>& n) {
    return std::any_of(all.begin(), all.end(),
                       [&](const Vec<Dim>& m) { return length(m - n) < 2e-3; });
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("the vertices are those of the plain definition", "[pack][caps]",
                       ((int Dim), Dim), 2, 3) {
    const auto seed = GENERATE(range(1u, 41u));
    CAPTURE(Dim, seed);
    RandomStream random(seed, Dim);
    const auto caps = randomCaps<Dim>(random, 1 + static_cast<int>(random.uniform() * 30));
    CapSet<Dim> set;
    for (std::size_t i = 0; i < caps.size(); ++i) {
        std::array<float, Dim> axis;
        for (std::size_t d = 0; d < Dim; ++d) axis[d] = static_cast<float>(caps[i].axis.c[d]);
        REQUIRE(set.add(axis, static_cast<float>(caps[i].height), static_cast<std::uint32_t>(i)));
    }
    std::vector<typename CapSet<Dim>::Vertex> vertices;
    set.findVertices(vertices);
    std::vector<Vec<Dim>> found;
    for (const auto& v : vertices) {
        Vec<Dim> n;
        for (std::size_t d = 0; d < Dim; ++d) n.c[d] = v.direction[d];
        found.push_back(n);
        // On the boundaries of the caps it names.
        for (const auto body : v.bodies)
            CHECK(dot(n, caps[body].axis) == Approx(caps[body].height).margin(2e-4));
    }
    for (const auto& n : bruteForce(caps, -1e-3)) CHECK(holds(found, n));  // none is missed
    const auto generous = bruteForce(caps, 1e-3);
    for (const auto& n : found) CHECK(holds(generous, n));  // none is made up
}

TEST_CASE("a cap that forbids nothing or everything is said so", "[pack][caps]") {
    CapSet<3> set;
    CHECK(set.add({1, 0, 0}, 1.0f, 0));
    CHECK(set.size() == 0);
    CHECK_FALSE(set.add({1, 0, 0}, -1.0f, 0));
}
