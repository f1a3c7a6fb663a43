#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/measure/morphometry/mean_intercept.h"
#include "vdbpack/measure/morphometry/morphometry.h"

TEST_CASE("a Boolean model of balls has the volume and the chords of theory") {
    const double radius = 0.5, side = 6;
    Voids voids;
    voids.semiAxes = {radius, radius, radius};
    voids.perVolume = 1.6;
    double solid = 0, area = 0, crossings = 0, da = 0;
    constexpr int kSamples = 4;
    for (int i = 0; i < kSamples; ++i) {
        voids.seed = 100 + static_cast<std::uint64_t>(i);
        const auto m = measureMorphometry(voidsImage(72, side / 72, voids));
        REQUIRE(m.anisotropy);
        solid += m.solidFraction / kSamples;
        area += m.solidSurface / m.totalVolume / kSamples;
        for (const auto& length : m.anisotropy->meanInterceptLengths)
            crossings += 1 / length.value() / 3 / kSamples;
        da += m.anisotropy->degree / kSamples;
    }
    const double n = voids.perVolume;
    // Volume: exp(-n v). Standard error of four samples of 350 balls about 3 %.
    REQUIRE(solid == within(std::exp(-n * voids.volume()), 0.06));
    // What no ball covers has chords of mean length 1 / (n pi r²), two crossings each. Between
    // voxel centers h apart the short ones are missed: the two-point probability
    // exp(-n v (1 + 3h / 4r - h³ / 16r³)) says how many, about 5 %.
    const double h = side / 72, nv = n * voids.volume();
    const double step = 0.75 * h / radius - std::pow(h / radius, 3) / 16;
    const double chord = h / (1 - std::exp(-nv * step));
    REQUIRE(chord == within(1 / (n * kPi * radius * radius), 0.06));
    REQUIRE(2 * solid / crossings == within(chord, 0.02));
    REQUIRE(area == within(4 * solid / chord, 0.03));
    REQUIRE(da < 0.2);
}

TEST_CASE("an ellipsoid of intercepts is found again") {
    const auto directions = halfSphereDirections(500);
    const Vec<3> u = normalized(Vec<3>{{1, 2, -2}});
    const auto [e, g] = across(u);
    std::vector<double> rates;
    for (const auto& d : directions) {
        const double a = dot(d, u) / 0.9, b = dot(d, e) / 0.6, c = dot(d, g) / 0.5;
        rates.push_back(0.1 * std::sqrt(a * a + b * b + c * c));
    }
    const auto fit = fitAnisotropy(directions, rates, 0.1);
    REQUIRE(fit);
    REQUIRE(fit->meanInterceptLengths[0].value() == Approx(0.9));
    REQUIRE(fit->meanInterceptLengths[1].value() == Approx(0.6));
    REQUIRE(fit->meanInterceptLengths[2].value() == Approx(0.5));
    REQUIRE(fit->degree == Approx(1 - 25.0 / 81));
    REQUIRE(fit->ratio.value() == Approx(1.8));
    REQUIRE(fit->eigenvalues[2] == Approx(4));
    REQUIRE(std::abs(dot(fit->axes[0], u)) == Approx(1));
    REQUIRE(fit->axes[0][1] > 0);
}
