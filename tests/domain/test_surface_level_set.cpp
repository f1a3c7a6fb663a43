#include "support/generators.h"
#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/voxel_image.h"

namespace {

/// Samples the surface of a domain in voxels of `h` mm and compares it with the nearest wall
/// points.
/// @param exactSigns  of all voxels. @param error  allowed where a voxel lies at a distance, mm.
template <class Error>
void requireSurface(const Domain<3>& domain, double h, bool exactSigns, const Error& error) {
    const auto grid = surfaceLevelSet(domain, h);
    CHECK(voxelSizeOf(*grid) == Approx(h));
    const auto image = sampleLevelSet(*grid, domain.bounds().grown(5 * h));
    const auto sampler = domain.sampler();
    std::size_t inside = 0, deep = 0;
    for (std::size_t i = 0; i < image.voxels(); ++i) {
        const double d = static_cast<double>(image.distance[i]);
        inside += d < 0;
        deep += d < -2.999 * h;
        if (i % 29 != 0) continue;
        const Vec<3> x = centerOf(image, i);
        WallPoint<3> wall;
        REQUIRE(sampler->nearestWall(x, 1e3, wall));
        const double truth = sampler->contains(x) ? -wall.distance : wall.distance;
        CAPTURE(x.c, d, truth);
        REQUIRE(std::fabs(d - std::clamp(truth, -3 * h, 3 * h)) < error(truth));
        if (exactSigns && std::fabs(truth) > 1e-6) REQUIRE((d < 0) == (truth < 0));
    }
    CHECK(static_cast<double>(inside) * h * h * h == Approx(domain.volume()).epsilon(0.01));
    CHECK(deep > 100);
}

}  // namespace

TEST_CASE("the surface of a shape in voxels is where the shape ends") {
    struct Case {
        const char* name;
        std::shared_ptr<const Domain<3>> domain;
        bool exact;  ///< outside of edges, too
    };
    const std::vector<Case> cases{
        {"box", boxDomain<3>({{{-3, 1, 2}}, {{9, 8, 7}}}), true},
        {"ball", ballDomain<3>(5, {{1, 2, 3}}), true},
        {"cylinder", cylinderDomain(4, 9), true},
        {"half a ball",
         clippedDomain<3>(ballDomain<3>(6), {{{{1, 0.5, 0}}, 1}, {{{0, -0.3, 1}}, 2}}), false},
        // 400 voxels across: most of it in tiles.
        {"large ball", ballDomain<3>(50), true}};
    for (const auto& [name, domain, exact] : cases) {
        CAPTURE(name);
        const double h = domain->bounds().size()[0] > 50 ? 0.5 : 0.2;
        const bool everywhere = exact;
        requireSurface(*domain, h, true, [&](double truth) {
            return everywhere || truth < 0 ? 1e-5 * h + 1e-5 : 4 * h;
        });
    }
}

TEST_CASE("the surface of a mesh is known in voxels of any size") {
    FieldOptions options;
    options.voxelSize = 0.2;
    const auto mesh = meshDomain(ballMesh(6, 5), options);
    const std::vector<HalfSpace<3>> planes{{{{1, 0.3, -0.2}}, 2}};
    // Voxels of 0.7 mm reach farther than the field of the mesh.
    for (const double h : {0.2, 0.35, 0.7})
        for (const bool clipped : {false, true}) {
            const std::shared_ptr<const Domain<3>> domain =
                clipped ? clippedDomain<3>(mesh, planes) : mesh;
            CAPTURE(h, clipped, domain->fieldDepth());
            requireSurface(*domain, h, false, [&](double truth) {
                return truth > 0 ? 8 * h : truth > -h ? 0.1 * h : 0.5 * h;
            });
        }
}
