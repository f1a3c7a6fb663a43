// What a build without Embree says.
#include "vdbpack/core/error.h"
#include "vdbpack/preview/scene.h"

namespace vdbpack {

namespace {

[[noreturn]] void refuse() {
    throw ParameterError(
        "--preview: this build cannot draw what lies in space, which needs Embree 3; install "
        "libembree-dev and build again, or leave --preview out");
}

}  // namespace

bool canDrawSpace() {
    return false;
}

std::vector<std::int32_t> visibleSpheres(const SpacePreview&, const PreviewOptions&) {
    refuse();
}

Image renderPreview(const SpacePreview&, const PreviewOptions&) {
    refuse();
}

}  // namespace vdbpack
