// The errors of a build without Embree.
#include "vdbpack/core/error.h"
#include "vdbpack/preview/preview.h"

namespace vdbpack {

namespace {

[[noreturn]] void refuse() {
    throw ParameterError(
        "`preview.file`: this build cannot draw scenes in space, which needs Embree; install "
        "libembree-dev and build again, or leave it out");
}

}  // namespace

bool canDrawSpace() {
    return false;
}

std::vector<std::int32_t> visibleSpheres(const SpacePreview&, const PreviewOptions&) {
    refuse();
}

Picture renderPreview(const SpacePreview&, const PreviewOptions&) {
    refuse();
}

}  // namespace vdbpack
