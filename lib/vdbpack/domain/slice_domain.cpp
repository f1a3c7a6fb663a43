#include "vdbpack/core/error.h"
#include "vdbpack/domain/clipped_domain.h"

#include <fmt/format.h>

#include <cmath>

namespace vdbpack {

std::shared_ptr<const Domain<2>> sliceDomain(std::shared_ptr<const Domain<3>> domain,
                                             double height) {
    if (!std::isfinite(height))
        throw ParameterError(fmt::format("slice: z={} is not finite; give a height in mm", height));
    const auto* sliceable = dynamic_cast<const Sliceable*>(domain.get());
    if (!sliceable)
        throw ParameterError(
            fmt::format("slice: a domain of kind '{}' cannot be sliced; slice a mesh, a level set, "
                        "a box, a ball or a cylinder",
                        domain->facts().kind));
    return sliceable->slice(height);
}

}  // namespace vdbpack
