// Densified packs: no overlap, nothing outside, the radii that were given, the same for any
// threads.
#include "support/generators.h"
#include "support/paths.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace vdbpack;

namespace {

constexpr double kMax = std::numeric_limits<double>::infinity();

template <int Dim>
std::shared_ptr<const Domain<Dim>> box(double side, const Vec<Dim>& center = {}) {
    return boxDomain<Dim>(
        {center + Box<Dim>::filled(-side / 2), center + Box<Dim>::filled(side / 2)});
}

SizeDistribution sizesOf(const std::string& spec, int dim) {
    return SizeDistribution::parse(spec, dim);
}

template <int Dim>
std::vector<Sphere<Dim>> front(const Domain<Dim>& domain, const std::string& spec) {
    return packSpheres(domain, PackOptions(sizesOf(spec, Dim))).pack.spheres;
}

template <int Dim>
DensifyOptions to(double fraction, const std::string& spec) {
    DensifyOptions options;
    options.fraction = fraction;
    if (!spec.empty()) options.sizes = sizesOf(spec, Dim);
    return options;
}

/// How far spheres protrude from a shape whose own distances are exact, mm.
template <int Dim>
double protrusion(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    const auto sampler = domain.sampler();
    double most = 0;
    for (const auto& s : spheres)
        most = std::max(most, s.radius + sampler->signedDistance(s.center));
    return most;
}

template <int Dim>
void checkSound(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    CHECK(checkOverlap(spheres).max == 0);
    CHECK(protrusion(spheres, domain) <= 0);
}

template <int Dim>
std::vector<double> sortedRadii(const std::vector<Sphere<Dim>>& spheres) {
    std::vector<double> radii;
    for (const auto& s : spheres) radii.push_back(s.radius);
    std::sort(radii.begin(), radii.end());
    return radii;
}

/// The radii that were given are all there, to the last bit.
template <int Dim>
void checkRadii(const std::vector<Sphere<Dim>>& before, const std::vector<Sphere<Dim>>& after) {
    const auto given = sortedRadii(before), all = sortedRadii(after);
    CHECK(std::includes(all.begin(), all.end(), given.begin(), given.end()));
}

template <int Dim>
std::vector<Sphere<Dim>> shaken(std::vector<Sphere<Dim>> spheres, double by) {
    RandomStream random(5, 6);
    for (auto& s : spheres)
        for (int d = 0; d < Dim; ++d) s.center[d] += by * (2 * random.uniform() - 1);
    return spheres;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("a densified pack is denser, sound, and of the requested sizes", "[densify]",
                       ((int Dim), Dim), 2, 3) {
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
    std::vector<double> radii, all;
    for (const auto& s : before) radii.push_back(s.radius);
    for (const auto& s : result.spheres) all.push_back(s.radius);
    const auto sizes = sizesOf(spec, Dim);
    const auto cdf = [&](double r) { return sizes.cdf(r); };
    CHECK(ksDistance(all, cdf) <= ksDistance(radii, cdf) + 2.0 / static_cast<double>(all.size()));
}

TEST_CASE("spheres of a densified pack touch their neighbors", "[densify]") {
    const std::string spec = "uniform:1,2";
    const auto domain = box<3>(40);
    const auto before = front(*domain, spec);
    for (const double fraction : {0.625, 0.645}) {
        CAPTURE(fraction);
        const auto result = densify(*domain, before, to<3>(fraction, spec));
        REQUIRE(result.reached);
        const auto contacts = countContacts(result.spheres, 1e-3);
        CHECK(contacts.meanOfSpheres > 4.8);
        CHECK(contacts.largestComponent > 0.99);
        CHECK(countContacts(result.spheres, 1e-4).meanOfSpheres > 4.2);
        checkSound(result.spheres, *domain);
    }
}

TEST_CASE("disks of a densified pack touch their neighbors", "[densify]") {
    const auto domain = box<2>(150);
    const auto before = front(*domain, "uniform:1,2");
    const auto result = densify(*domain, before, to<2>(0.84, "uniform:1,2"));
    REQUIRE(result.reached);
    CHECK(countContacts(result.spheres, 1e-3).meanOfSpheres > 3);
    CHECK(countContacts(result.spheres, 1e-4).meanOfSpheres > 2.7);
    checkSound(result.spheres, *domain);
}

TEMPLATE_TEST_CASE_SIG("spheres are drawn together only if that is wanted, and by a short way",
                       "[densify]", ((int Dim), Dim), 2, 3) {
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
    for (std::size_t i = 0; i < apart.spheres.size(); ++i) {
        CHECK(touching.spheres[i].radius == apart.spheres[i].radius);
        CHECK(length(touching.spheres[i].center - apart.spheres[i].center) < 0.5);
    }
}

TEST_CASE("a pack interrupted while its spheres are drawn together is sound", "[densify]") {
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

TEST_CASE("spheres stay near their places, and exchange radii that are nearly equal", "[densify]") {
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

TEMPLATE_TEST_CASE_SIG("a densified pack is the same for any number of threads", "[densify]",
                       ((int Dim), Dim), 2, 3) {
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

TEMPLATE_TEST_CASE_SIG("overlaps of packs of any origin are removed", "[densify]", ((int Dim), Dim),
                       2, 3) {
    // Far off the origin, and in lengths of another size.
    const double unit = GENERATE(1e-3, 1.0, 1e3);
    CAPTURE(Dim, unit);
    const Vec<Dim> center = Box<Dim>::filled(300 * unit);
    const auto domain = box<Dim>((Dim == 3 ? 24 : 60) * unit, center);
    auto given = front<Dim>(*box<Dim>(Dim == 3 ? 24 : 60), "uniform:1,2");
    given = shaken(given, 0.04);
    for (auto& s : given) {
        s.center = s.center * unit + center;
        s.radius *= unit;
    }
    REQUIRE(checkOverlap(given).max > 0.02);
    REQUIRE(protrusion(given, *domain) > 0);
    const auto result = densify(*domain, given, {});
    CHECK(result.apart);
    CHECK(result.spheres.size() == given.size());
    checkRadii(given, result.spheres);
    checkSound(result.spheres, *domain);
}

TEST_CASE("the spheres of a pack that YADE compressed are separated", "[densify]") {
    const auto given = readPack("yade:" + test::kTests + "/densify/yade_pack.txt").spheres;
    const auto domain = boxDomain<3>({{}, Box<3>::filled(10)});
    REQUIRE(checkOverlap(given).max > 0.02);
    const auto result = densify(*domain, given, {});
    CHECK(result.apart);
    checkRadii(given, result.spheres);
    checkSound(result.spheres, *domain);
    CHECK(solidFraction(result.spheres, *domain) ==
          Approx(solidFraction(given, *domain)).margin(0.002));
}

TEST_CASE("a pack without overlaps is left as it is", "[densify]") {
    const auto domain = box<3>(20);
    const auto before = front(*domain, "uniform:1,2");
    const auto result = densify(*domain, before, {});
    CHECK(result.apart);
    CHECK(result.steps == 0);
    CHECK(result.spheres == before);
}

TEST_CASE("spheres on the same spot are separated", "[densify]") {
    const auto domain = box<3>(20);
    std::vector<Sphere<3>> given(30, Sphere<3>{{{1, 2, 3}}, 1.0});
    const auto result = densify(*domain, given, {});
    CHECK(result.apart);
    checkSound(result.spheres, *domain);
}

TEST_CASE("fixed spheres stay where they are, and the others keep off them", "[densify]") {
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

TEST_CASE("spheres keep to their regions, and those added are like them", "[densify]") {
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

TEST_CASE("a gap is kept while a pack gets denser", "[densify]") {
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

TEST_CASE("spheres of very different sizes are relaxed together", "[densify]") {
    const auto domain = box<3>(30);
    const std::string spec = "lognormal:0.7,0.6,0.2,6";
    const auto before = front(*domain, spec);
    const auto result =
        densify(*domain, shaken(before, 0.02), to<3>(solidFraction(before, *domain), spec));
    CHECK(result.apart);
    checkRadii(before, result.spheres);
    checkSound(result.spheres, *domain);
}

TEST_CASE("no sphere leaves a wall of triangles", "[densify]") {
    // A ball with a ball cut out of it: walls that bend either way, and thin places.
    TriangleMesh mesh = test::ballMesh(14, 4);
    TriangleMesh inner = test::ballMesh(8, 4);
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
    CHECK(countContacts(result.spheres, 1e-3).meanOfSpheres > 4);
}

TEST_CASE("a fraction out of reach is approached from below", "[densify]") {
    const auto domain = box<3>(16);
    const auto before = front(*domain, "uniform:1,2");
    const auto result = densify(*domain, before, to<3>(0.8, "uniform:1,2"));
    CHECK(result.apart);
    CHECK_FALSE(result.reached);
    CHECK(result.after > result.before);
    checkSound(result.spheres, *domain);
    const auto max = densify(*domain, before, to<3>(kMax, ""));
    CHECK(max.after > result.before + 0.01);
    checkSound(max.spheres, *domain);
}

TEST_CASE("a pack that is interrupted while it gets denser is the last that was apart",
          "[densify]") {
    const auto domain = box<3>(20);
    const auto before = front(*domain, "uniform:1,2");
    Callbacks callbacks;
    int asked = 0;
    callbacks.cancelled = [&] { return ++asked > 40; };
    const auto result = densify(*domain, before, to<3>(0.66, "uniform:1,2"), callbacks);
    CHECK(result.interrupted);
    CHECK(result.spheres == before);
}

TEST_CASE("more spheres than fit cannot be separated, and are returned", "[densify]") {
    const auto domain = box<3>(6);
    const std::vector<Sphere<3>> given(40, Sphere<3>{{{1, 0, 0}}, 1.5});
    const auto result = densify(*domain, given, {});
    CHECK_FALSE(result.apart);
    CHECK_FALSE(result.reached);
    CHECK(result.spheres == given);
}

TEST_CASE("equal spheres get denser without crystallizing", "[densify][long]") {
    const auto domain = box<3>(40);
    const auto before = front(*domain, "constant:1");
    struct Case {
        double fraction, most;  // share in crystalline order
    };
    for (const Case& c : {Case{0.6, 0.02}, Case{kMax, 0.08}}) {
        CAPTURE(c.fraction);
        const auto result = densify(*domain, before, to<3>(c.fraction, "constant:1"));
        CHECK(result.after > 0.5999);
        CHECK(solidLikeShare(result.spheres) < c.most);
        checkSound(result.spheres, *domain);
        if (c.fraction == kMax) CHECK(result.after > 0.608);
    }
}

TEST_CASE("equal spheres without walls get as dense as random packs can be",
          "[densify][periodic]") {
    const PeriodicCell<3> cell{{{}, {{24, 24, 24}}}, {true, true, true}};
    const auto domain = periodicDomain(cell);
    const auto before = front(*domain, "constant:1");
    const auto result = densify(*domain, before, to<3>(kMax, "constant:1"));
    CHECK(result.after > 0.635);
    CHECK(solidLikeShare(result.spheres, cell) < 0.03);
    CHECK(checkOverlap(result.spheres, cell).max == 0);
}

TEST_CASE("in a cell, too, a request out of reach ends no less dense than the densest pack",
          "[densify][periodic]") {
    const std::string spec = GENERATE(as<std::string>{}, "constant:1", "uniform:1,2");
    const PeriodicCell<3> cell{{{}, {{20, 20, 20}}}, {true, true, true}};
    const auto domain = periodicDomain(cell);
    const auto before = front(*domain, spec);
    const auto densest = densify(*domain, before, to<3>(kMax, spec));
    const auto beyond = densify(*domain, before, to<3>(0.8, spec));
    CHECK_FALSE(beyond.reached);
    CHECK(beyond.after >= densest.after);
}

TEST_CASE("equal spheres of a loose pack get as dense as those of a front", "[densify][long]") {
    const auto domain = box<3>(30);
    auto before = front(*domain, "constant:1");
    for (std::size_t i = 0; 3 * i + 2 < before.size(); ++i)
        before.erase(before.begin() + static_cast<std::ptrdiff_t>(2 * i));
    const auto result = densify(*domain, before, to<3>(kMax, "constant:1"));
    CHECK(result.before < 0.45);
    CHECK(result.after > 0.58);
    checkSound(result.spheres, *domain);
}

TEST_CASE("densities and gaps that cannot be are refused", "[densify]") {
    const auto domain = box<3>(10);
    const auto before = front(*domain, "constant:1");
    using Catch::Matchers::Contains;
    const auto refused = [&](const DensifyOptions& options, const std::string& why) {
        CHECK_THROWS_MATCHES(densify(*domain, before, options), ParameterError,
                             Catch::Matchers::Predicate<ParameterError>([&](const auto& e) {
                                 return std::string(e.what()).find(why) != std::string::npos;
                             }));
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

TEMPLATE_TEST_CASE_SIG("a request out of reach ends no less dense than the densest pack",
                       "[densify]", ((int Dim), Dim), 2, 3) {
    const std::string spec = "uniform:1,2";
    const auto domain = box<Dim>(Dim == 3 ? 24 : 60);
    const auto before = front(*domain, spec);
    const auto densest = densify(*domain, before, to<Dim>(kMax, spec));
    for (const double wanted : {densest.after + 0.01, densest.after + 0.05, 0.93}) {
        CAPTURE(Dim, wanted, densest.after);
        const auto result = densify(*domain, before, to<Dim>(wanted, spec));
        CHECK(result.after >= densest.after);
        CHECK(result.reached == (result.after >= wanted));
        checkSound(result.spheres, *domain);
    }
}
