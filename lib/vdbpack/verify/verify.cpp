#include "vdbpack/verify/verify.h"

namespace vdbpack {

bool VerifyResult::passed() const {
    return overlap.pairs == 0 && (!protrusion || protrusion->spheres == 0) &&
           (!ks || *ks <= ksLimit);
}

template <int Dim>
VerifyResult verifyPack(const Pack<Dim>& pack) {
    VerifyResult result;
    result.overlap = checkOverlap(pack.spheres, pack.cell);
    result.count = pack.spheres.size();
    result.radius = radiusStatistics(pack.spheres);
    result.hash = packHash(pack);
    return result;
}

VerifyResult verifyPack(const Pack<3>& pack, const TriangleMesh& wall) {
    VerifyResult result = verifyPack(pack);
    result.protrusion = checkProtrusion(pack.spheres, wall);
    return result;
}

template <int Dim>
VerifyResult verifyPack(const Pack<Dim>& pack, const WallShape<Dim>& wall) {
    VerifyResult result = verifyPack(pack);
    result.protrusion = checkProtrusion(pack.spheres, wall);
    return result;
}

template VerifyResult verifyPack<2>(const Pack<2>&);
template VerifyResult verifyPack<3>(const Pack<3>&);
template VerifyResult verifyPack<2>(const Pack<2>&, const WallShape<2>&);
template VerifyResult verifyPack<3>(const Pack<3>&, const WallShape<3>&);

}  // namespace vdbpack
