#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/welding.h"

TEST_CASE("the field of solids that touch along an edge knows their smallest pores") {
    const auto mesh = welded(merged(boxMesh({{0, 0, 0}}, {{4, 4, 4}}),
                                    merged(boxMesh({{4, 4, 0}}, {{8, 8, 4}}),
                                           boxMesh({{1.99, 1.99, 1.99}}, {{2.01, 2.01, 2.01}}))));
    REQUIRE(checkMesh(mesh).nonManifoldEdges == 1);
    FieldOptions options;
    options.voxelSize = options.detail = 0.3;
    options.depth = 2;
    const auto domain = meshDomain(mesh, options);
    CHECK(domain->volume() == Approx(128));
    const std::vector<double> depths{0, 0.5, 1, 1.9, 2};
    const auto volumes = domain->volumesDeeperThan(depths);
    for (std::size_t i = 0; i < depths.size(); ++i)
        CHECK(volumes[i] == Approx(domain->volumeDeeperThan(depths[i])).epsilon(1e-12));
    CHECK(volumes[1] < 2 * 27);
    const auto asker = domain->sampler();
    CHECK(asker->signedDistance({{2.6, 2, 2}}) == Approx(-0.59).margin(0.1));
    CHECK(asker->signedDistance({{6, 6, 1}}) == Approx(-1).margin(0.01));
}
