// Densified packs: no overlap, nothing outside, the radii that were given, the same for any
// threads.
#include "densify/densifying.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"

DIM_TEST_CASE("a densified pack is denser, sound, and of the requested sizes") {
    const std::string spec = "uniform:1,2";
    const double wanted = Dim == 3 ? 0.63 : 0.84;
    const auto domain = box<Dim>(Dim == 3 ? 40 : 150);
    const auto before = front(*domain, spec);
    const auto result = densify(*domain, before, to<Dim>(wanted, spec));
    CHECK(result.apart);
    CHECK(result.reached);
    CHECK(result.before == Approx(solidFraction(before, *domain)));
    CHECK(result.before < wanted - 0.005);
    CHECK(result.after == Approx(solidFraction(result.spheres, *domain)));
    CHECK(result.after >= wanted);
    CHECK(result.after < wanted + 0.01);
    checkSound(result.spheres, *domain);
    checkRadii(before, result.spheres);
    for (const auto& s : result.spheres) {
        CHECK(s.radius >= 1);
        CHECK(s.radius <= 2);
    }
    const auto sizes = sizesOf(spec, Dim);
    CHECK(ksOf(result.spheres, sizes) <=
          ksOf(before, sizes) + 2.0 / static_cast<double>(result.spheres.size()));
}

DIM_TEST_CASE("spheres of a densified pack touch their neighbors") {
    const std::string spec = "uniform:1,2";
    const auto domain = box<Dim>(Dim == 3 ? 40 : 150);
    const auto before = front(*domain, spec);
    for (const double fraction : Dim == 3 ? std::vector{0.625, 0.645} : std::vector{0.84}) {
        CAPTURE(Dim, fraction);
        const auto result = densify(*domain, before, to<Dim>(fraction, spec));
        REQUIRE(result.reached);
        const auto contacts = countContacts(result.spheres, 1e-3);
        CHECK(contacts.meanOfSpheres > (Dim == 3 ? 4.8 : 3.0));
        if (Dim == 3) CHECK(contacts.largestComponent > 0.99);
        CHECK(countContacts(result.spheres, 1e-4).meanOfSpheres > (Dim == 3 ? 4.2 : 2.7));
        checkSound(result.spheres, *domain);
    }
}

DIM_TEST_CASE("spheres are drawn together only if that is wanted, and by a short way") {
    const std::string spec = "uniform:1,2";
    const auto domain = ballDomain<Dim>(Dim == 3 ? 14 : 40);
    const auto before = front(*domain, spec);
    auto options = to<Dim>(solidFraction(before, *domain) + 0.015, spec);
    const auto touching = densify(*domain, before, options);
    options.contacts = false;
    const auto apart = densify(*domain, before, options);
    REQUIRE(touching.reached);
    REQUIRE(apart.reached);
    CHECK(countContacts(apart.spheres, 1e-3).meanOfSpheres < 1);
    CHECK(countContacts(touching.spheres, 1e-3).meanOfSpheres > Dim);
    REQUIRE(touching.spheres.size() == apart.spheres.size());
    // But for a few that exchanged places.
    std::size_t exchanged = 0;
    for (std::size_t i = 0; i < apart.spheres.size(); ++i)
        exchanged += touching.spheres[i].radius != apart.spheres[i].radius ||
                     length(touching.spheres[i].center - apart.spheres[i].center) > 0.5;
    CHECK(static_cast<double>(exchanged) < 0.01 * static_cast<double>(apart.spheres.size()));
}

TEST_CASE("a pack interrupted while its spheres are drawn together is sound") {
    const std::string spec = "uniform:1,2";
    const auto domain = box<3>(20);
    const auto before = front(*domain, spec);
    auto options = to<3>(0.6, spec);
    bool drawn = false;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) {
        drawn = drawn || p.stage == "densify, contacts";
    };
    callbacks.cancelled = [&] { return drawn; };
    const auto result = densify(*domain, before, options, callbacks);
    CHECK(drawn);
    CHECK(result.interrupted);
    CHECK(result.reached);
    options.contacts = false;
    CHECK(result.spheres == densify(*domain, before, options).spheres);
}

TEST_CASE("spheres stay near their places, and exchange radii that are nearly equal") {
    const std::string spec = "uniform:1,2";
    const auto domain = box<3>(40);
    const auto before = front(*domain, spec);
    const auto result = densify(*domain, before, to<3>(0.63, spec));
    REQUIRE(result.reached);
    std::vector<double> moves;
    std::size_t exchanged = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        moves.push_back(length(result.spheres[i].center - before[i].center));
        exchanged += result.spheres[i].radius != before[i].radius;
    }
    const auto middle = moves.begin() + static_cast<std::ptrdiff_t>(moves.size() / 2);
    std::nth_element(moves.begin(), middle, moves.end());
    CHECK(*middle < 1.5);  // a mean radius
    CHECK(*std::max_element(moves.begin(), moves.end()) < 10);
    CHECK(exchanged > before.size() / 10);
}

DIM_TEST_CASE("a densified pack is the same for any number of threads") {
    const std::string spec = GENERATE("uniform:1,2", "lognormal:1,0.5,0.4,4");
    const auto domain = ballDomain<Dim>(Dim == 3 ? 14 : 40);
    const auto before = front(*domain, spec);
    std::vector<Sphere<Dim>> first;
    for (const int threads : {1, 2, 3, 8}) {
        CAPTURE(threads, spec);
        const auto result = withThreads(threads, [&] {
            return densify(*domain, before, to<Dim>(solidFraction(before, *domain) + 0.015, spec));
        });
        CHECK(result.reached);
        if (first.empty()) first = result.spheres;
        CHECK(result.spheres == first);
    }
}

DIM_TEST_CASE("a settled front does not tell where it began") {
    const std::string spec = "uniform:1,2";
    const auto domain = box<Dim>(Dim == 3 ? 50 : 150);
    PackOptions swept(sizesOf(spec, Dim));
    swept.order = Order::sweep;
    const auto before = packSpheres(*domain, swept).pack.spheres;
    // The share of the contacts' fabric along the diagonal, on which the front advances.
    const auto along = [](const std::vector<Sphere<Dim>>& spheres) {
        const auto network = countContacts(spheres, 1e-3);
        double sum = 0;
        for (std::size_t i = 0; i < Dim; ++i)
            for (std::size_t j = 0; j < Dim; ++j) sum += network.fabric[i].c[j];
        return sum / Dim;
    };
    constexpr double kIsotropic = 1.0 / Dim;
    CHECK(along(before) > kIsotropic + 0.05);
    DensifyOptions options;
    options.settle = true;
    std::vector<Sphere<Dim>> first;
    for (const int threads : {1, 3}) {
        const auto result = withThreads(threads, [&] { return densify(*domain, before, options); });
        REQUIRE(result.apart);
        if (first.empty()) first = result.spheres;
        CHECK(result.spheres == first);
    }
    CHECK(along(first) == Approx(kIsotropic).margin(Dim == 3 ? 0.012 : 0.03));
    CHECK(countContacts(first, 1e-3).meanOfSpheres > (Dim == 3 ? 5 : 3.2));
    checkSound(first, *domain);
    checkRadii(before, first);
}

TEST_CASE("fixed spheres stay where they are, and the others keep off them") {
    const auto domain = box<3>(30);
    auto given = front(*domain, "uniform:1,2");
    // Every seventh one first, shaken into the others and into one another.
    std::vector<Sphere<3>> sorted;
    for (std::size_t i = 0; i < given.size(); i += 7) sorted.push_back(given[i]);
    const std::size_t fixed = sorted.size();
    for (std::size_t i = 0; i < given.size(); ++i)
        if (i % 7 != 0) sorted.push_back(given[i]);
    auto options = to<3>(solidFraction(given, *domain) + 0.004, "uniform:1,2");
    options.fixed = fixed;
    const auto result = densify(*domain, sorted, options);
    CHECK(result.reached);
    for (std::size_t i = 0; i < fixed; ++i) CHECK(result.spheres[i] == sorted[i]);
    CHECK(result.spheres[fixed].center != sorted[fixed].center);
    CHECK(countContacts(result.spheres, 1e-3).meanOfSpheres > 4);
    checkSound(result.spheres, *domain);
}

TEST_CASE("spheres keep to their regions, and those added are like them") {
    // Small ones below, large ones above, which a front has not laid at one time.
    const auto lower = boxDomain<3>({{{-12, -12, -12}}, {{12, 12, 0}}});
    const auto upper = boxDomain<3>({{{-12, -12, 0}}, {{12, 12, 12}}});
    const auto domain = box<3>(24);
    auto spheres = front<3>(*lower, "uniform:0.6,0.9");
    const std::size_t below = spheres.size();
    const auto large = front<3>(*upper, "uniform:0.8,1.2");
    spheres.insert(spheres.end(), large.begin(), large.end());
    auto options = to<3>(solidFraction(spheres, *domain) + 0.02, "");
    for (std::size_t i = 0; i < spheres.size(); ++i) options.regions.push_back(i < below ? 7 : -1);
    const auto result = densify<3>(*domain, spheres, options);
    CHECK(result.reached);
    checkSound(result.spheres, *domain);
    checkRadii(spheres, result.spheres);
    REQUIRE(result.regions.size() == result.spheres.size());
    CHECK(std::equal(options.regions.begin(), options.regions.end(), result.regions.begin()));
    double added[2] = {0, 0};
    for (std::size_t i = 0; i < result.spheres.size(); ++i) {
        const auto& s = result.spheres[i];
        const bool isBelow = result.regions[i] == 7;
        // Nothing came farther across the plane between the two than a diameter.
        CHECK((isBelow ? s.center[2] : -s.center[2]) < 2);
        if (i < spheres.size()) continue;
        CHECK(s.radius >= (isBelow ? 0.6 : 0.8));
        CHECK(s.radius <= (isBelow ? 0.9 : 1.2));
        added[isBelow ? 0 : 1] += Measure<3>::ball(s.radius);
    }
    CHECK(added[0] / added[1] == Approx(1).epsilon(0.3));
    options.regions.pop_back();
    CHECK_THROWS_AS(densify<3>(*domain, spheres, options), ParameterError);
}

TEST_CASE("a gap is kept while a pack gets denser") {
    const double gap = 0.1;
    const auto domain = ballDomain<3>(15);
    PackOptions packing(sizesOf("uniform:1,2", 3));
    packing.gap = gap;
    const auto before = packSpheres(*domain, packing).pack.spheres;
    auto options = to<3>(solidFraction(before, *domain) + 0.01, "uniform:1,2");
    options.gap = gap;
    const auto result = densify(*domain, before, options);
    CHECK(result.reached);
    checkRadii(before, result.spheres);
    auto grown = result.spheres;
    for (auto& s : grown) s.radius += gap / 2;
    CHECK(checkOverlap(grown).max == 0);
    CHECK(countContacts(grown, 1e-3).meanOfSpheres > 4);
    for (auto& s : grown) s.radius += gap / 2;
    CHECK(protrusion(grown, *domain) <= 0);
}

TEST_CASE("spheres of very different sizes are relaxed together") {
    const auto domain = box<3>(30);
    const std::string spec = "lognormal:0.7,0.6,0.2,6";
    const auto before = front(*domain, spec);
    const auto result =
        densify(*domain, shaken(before, 0.02), to<3>(solidFraction(before, *domain), spec));
    CHECK(result.apart);
    checkRadii(before, result.spheres);
    checkSound(result.spheres, *domain);
}

TEST_CASE("no sphere leaves a wall of triangles") {
    // A ball with a ball cut out of it: walls that bend either way, and thin places.
    TriangleMesh mesh = ballMesh(14, 4), inner = ballMesh(8, 4);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const auto& v : inner.vertices) mesh.vertices.push_back(v + Vec<3>{{3, 0, 0}});
    for (const auto& t : inner.triangles)
        mesh.triangles.push_back({t[0] + first, t[2] + first, t[1] + first});
    FieldOptions field;
    field.detail = 1;
    field.depth = 6;
    const auto domain = meshDomain(mesh, field);
    const auto before = front<3>(*domain, "uniform:1,2");
    const auto result =
        densify<3>(*domain, before, to<3>(solidFraction(before, *domain) + 0.015, "uniform:1,2"));
    CHECK(result.reached);
    CHECK(checkOverlap(result.spheres).max == 0);
    CHECK(checkProtrusion(result.spheres, mesh).max == 0);
    CHECK(countContacts(result.spheres, 1e-3).meanOfSpheres > 3.5);
}

TEST_CASE("a pack that is interrupted while it gets denser is the last that was apart") {
    const auto domain = box<3>(20);
    const auto before = front(*domain, "uniform:1,2");
    Callbacks callbacks;
    int asked = 0;
    callbacks.cancelled = [&] { return ++asked > 40; };
    const auto result = densify(*domain, before, to<3>(0.66, "uniform:1,2"), callbacks);
    CHECK(result.interrupted);
    CHECK(result.spheres == before);
}

TEST_CASE("densities and gaps that cannot be are refused") {
    const auto domain = box<3>(10);
    const auto before = front(*domain, "constant:1");
    const auto refused = [&](const DensifyOptions& options, const std::string& why) {
        const auto run = [&] { densify(*domain, before, options); };
        CHECK_THAT(messageOf<ParameterError>(run), Contains(why));
    };
    refused(to<3>(0.96, ""), "0.96");
    refused(to<3>(-0.1, ""), "-0.1");
    refused(to<3>(std::nan(""), ""), "nan");
    DensifyOptions options;
    options.gap = -1;
    refused(options, "`gap` -1 mm");
    options.gap = 0;
    options.fixed = before.size() + 1;
    refused(options, std::to_string(before.size() + 1));
    CHECK(densify(*domain, {}, to<3>(0.6, "")).spheres.empty());
}
