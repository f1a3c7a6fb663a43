#include "vdbpack/view/pack_view.h"

#include "vdbpack/preview/drawn_wall.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/report.h"
#include "vdbpack/view/view.h"

#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Distances along the longer side of a domain of the plane, for its outline, and voxels along the
/// diagonal of a 3D domain whose wall has no triangles or too many.
constexpr int kViewedDistances = 480, kViewedVoxels = 120;

}  // namespace

template <int Dim>
void addView(const PreviewOptions& recipe, const DomainSource* source,
             const DomainSource::Built& built, const Pack<Dim>& pack, const TriangleMesh* wall,
             bool large, PagePicture& picture) {
    ViewOptions options{source ? inWorldOf(*source, recipe) : inWorldOf(pack.origin, recipe)};
    options.large = large;
    ViewScene<Dim> scene;
    scene.pack = &pack;
    std::optional<WallMesh> mesh;
    std::optional<PlaneField> field;
    if constexpr (Dim == 3) {
        if (source) {
            mesh.emplace(*source, built, wall, options.mostTriangles, kViewedVoxels);
            scene.wall = mesh->get();
            scene.wallVoxel = mesh->voxelSize();
        }
    } else if (source) {
        scene.field = &field.emplace(planeField(*built.plane, nullptr, kViewedDistances));
        scene.bounds = built.plane->bounds();
    }
    ViewMarkup view = viewOf(scene, options);
    picture.viewStyle = std::move(view.style);
    picture.view = std::move(view.body);
}

void addView(const PreviewOptions& recipe, const TriangleMesh& surface,
             const std::vector<std::pair<std::string, std::size_t>>& solids, PagePicture& picture) {
    ViewOptions options{recipe};
    options.large = true;
    options.mostTriangles = surface.triangles.size();
    ViewScene<3> scene;
    scene.wall = &surface;
    scene.solids = solids;
    ViewMarkup view = viewOf(scene, options);
    picture.viewStyle = std::move(view.style);
    picture.view = std::move(view.body);
}

template void addView<2>(const PreviewOptions&, const DomainSource*, const DomainSource::Built&,
                         const Pack<2>&, const TriangleMesh*, bool, PagePicture&);
template void addView<3>(const PreviewOptions&, const DomainSource*, const DomainSource::Built&,
                         const Pack<3>&, const TriangleMesh*, bool, PagePicture&);

}  // namespace vdbpack
