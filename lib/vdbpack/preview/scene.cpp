#include "vdbpack/preview/scene.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <cmath>

namespace vdbpack {

template <int Dim>
Box<Dim> boundsOf(const Pack<Dim>& pack) {
    Box<Dim> bounds;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Sphere<Dim>& s = pack.spheres[i];
        if (!isFinite(s.center) || !(s.radius > 0) || !std::isfinite(s.radius))
            throw ParameterError(fmt::format(
                "preview: {} {} has radius {} or a center that is not finite; remove it",
                Measure<Dim>::kSphere, i, s.radius));
        const auto ball = Box<Dim>{s.center, s.center}.grown(s.radius);
        bounds.add(ball.lo);
        bounds.add(ball.hi);
    }
    return bounds;
}

template Box<2> boundsOf(const Pack<2>&);
template Box<3> boundsOf(const Pack<3>&);

void refuseInPlane(const PreviewOptions& options) {
    if (options.cut) throw ParameterError("`preview.cut`: a plane is flat already; leave it out");
    if (options.view)
        throw ParameterError("`preview.view`: a plane is drawn from above; leave it out");
}

Box<3> checkScene(const SpacePreview& scene, const PreviewOptions& options) {
    checkPreviewSize(options.width, options.height);
    Box<3> bounds;
    if (scene.pack) bounds = boundsOf(*scene.pack);
    for (const TriangleMesh* mesh : {scene.wall, scene.solid})
        if (mesh)
            for (const auto& v : mesh->vertices) bounds.add(v);
    if (bounds.empty())
        throw ParameterError("preview: the scene is empty; give spheres or a surface");
    if (options.cut) checkPreviewCut(*options.cut, bounds);
    return bounds;
}

void describe(const std::string& title, const std::string& description, Picture& image) {
    image.texts = {{"Title", title}, {"Description", description}};
}

std::string groupedCount(std::size_t n) {
    std::string text = std::to_string(n);
    for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
    return text;
}

}  // namespace vdbpack
