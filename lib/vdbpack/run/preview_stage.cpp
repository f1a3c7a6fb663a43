#include "vdbpack/run/preview_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/surface_level_set.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/run/report_file.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <memory>
#include <type_traits>
#include <utility>

namespace vdbpack {

namespace {

constexpr int kPageWidth = 960, kPageHeight = 720;
/// Voxels along the diagonal of a domain without triangles, for the surface that is drawn.
constexpr double kSurfaceVoxels = 300;
/// Distances beyond the bounds of a plane domain.
constexpr int kRim = 4;
/// The wall of a domain of space as triangles: its own where it has some.
class WallMesh {
public:
    /// @param known  the wall, if it is known already.
    WallMesh(const DomainSource& source, const DomainSource::Built& built,
             const TriangleMesh* known) {
        if (known) {
            mesh_ = known;
            return;
        }
        const bool whole = source.recipe().clips.empty();
        if (whole && built.mesh) {
            mesh_ = &built.mesh->wall();
            return;
        }
        const Domain<3>& domain = *built.space;
        const Box<3> bounds = domain.bounds();
        // Of a periodic cell the picture shows its box.
        made_ = whole && (domain.facts().kind == "box" || domain.cell().any())
                    ? boxMesh(bounds)
                    : levelSetMesh(*surfaceLevelSet(domain, length(bounds.size()) / kSurfaceVoxels),
                                   source.recipe().source);
        mesh_ = &made_;
    }
    const TriangleMesh* get() const { return mesh_; }

private:
    TriangleMesh made_;
    const TriangleMesh* mesh_ = nullptr;
};

/// Distances to the wall of a plane domain, less its voids, about a pixel apart.
PlaneField fieldOf(const Domain<2>& domain, const StampedVoids<2>* voids, int pixels) {
    const Box<2> bounds = domain.bounds();
    PlaneField field;
    const Vec<2> size = bounds.size();
    field.step = std::max(size[0], size[1]) / pixels;
    const auto count = [&](double side) {
        return static_cast<std::int64_t>(side / field.step) + 2 + 2 * kRim;
    };
    field.columns = count(size[0]);
    field.rows = count(size[1]);
    field.origin = bounds.grown(kRim * field.step).lo;
    field.distance.resize(static_cast<std::size_t>(field.columns * field.rows));
    struct Samplers {
        std::unique_ptr<DomainSampler<2>> domain;
        std::unique_ptr<StampedVoids<2>::Sampler> voids;
    };
    tbb::enumerable_thread_specific<Samplers> samplers([&] {
        return Samplers{domain.sampler(),
                        voids ? std::make_unique<StampedVoids<2>::Sampler>(*voids) : nullptr};
    });
    tbb::parallel_for(std::int64_t{0}, field.rows, [&](std::int64_t row) {
        Samplers& local = samplers.local();
        for (std::int64_t column = 0; column < field.columns; ++column) {
            const Vec<2> x = field.origin + Vec<2>{{static_cast<double>(column) * field.step,
                                                    static_cast<double>(row) * field.step}};
            double d = local.domain->signedDistance(x);
            if (local.voids) d = std::max(d, -(*local.voids)(x));
            field.distance[static_cast<std::size_t>(row * field.columns + column)] =
                static_cast<float>(d);
        }
    });
    return field;
}

Picture draw(const PreviewOptions& options, const DomainSource& source,
             const DomainSource::Built& built, const MadeVoids<3>& made, const Pack<3>* pack,
             const TriangleMesh* known) {
    SpacePreview scene;
    if (pack) {
        const WallMesh wall(source, built, known);
        scene.pack = pack;
        scene.wall = wall.get();
        return renderPreview(scene, options);
    }
    const TriangleMesh solid = levelSetMesh(*made.solid.grid, source.recipe().source);
    scene.solid = &solid;
    return renderPreview(scene, options);
}

Picture draw(const PreviewOptions& options, const DomainSource&, const DomainSource::Built& built,
             const MadeVoids<2>& made, const Pack<2>* pack, const TriangleMesh*) {
    const PlaneField field = fieldOf(*built.plane, pack ? nullptr : made.stamped.get(),
                                     std::max(options.width, options.height));
    PlanePreview scene;
    scene.pack = pack;
    scene.field = &field;
    scene.bounds = built.plane->bounds();
    return renderPreview(scene, options);
}

PreviewOptions optionsOf(const PreviewRecipe& recipe) {
    PreviewOptions options;
    options.color = recipe.color;
    options.column = recipe.column;
    options.cut = recipe.cut;
    options.width = recipe.width;
    options.height = recipe.height;
    return options;
}

/// Encodes a picture, and writes it if it has a file.
PreviewPicture finished(Picture image, const PreviewRecipe& recipe, const std::string& source) {
    PreviewPicture picture;
    for (const auto& [keyword, text] : image.texts)
        picture.words += (picture.words.empty() ? "" : ", ") + text;
    image.texts.emplace_back("Software", "vdb_pack " VDBPACK_VERSION);
    image.texts.emplace_back("Source", source);
    picture.png = encodePng(image);
    picture.width = image.width;
    picture.height = image.height;
    if (!recipe.file.empty()) {
        OutputFile file(recipe.file);
        file.write(picture.png);
        file.commit();
    }
    return picture;
}

}  // namespace

void checkPreview(const PreviewRecipe& recipe, const std::string& reportFile) {
    checkPreviewSize(recipe.width, recipe.height);
    const std::string& file = recipe.file;
    if (!file.empty() && extensionOf(file) != ".png")
        throw ParameterError("`preview.file` " + file + ": pictures are PNG; name it .png");
    const bool asked = recipe.cut || recipe.color != PreviewColor::radius;
    if (asked && file.empty() && !isPage(reportFile))
        throw ParameterError(
            std::string(recipe.cut ? "`preview.cut`" : "`preview.color`") +
            " has no effect without a picture; add `preview.file` FILE.png or `reportFile` "
            "FILE.html");
}

template <int Dim>
void checkPreview(const PreviewRecipe& recipe, const Domain<Dim>& domain, const Pack<Dim>* pack) {
    if (Dim == 3 && !recipe.file.empty() && !canDrawSpace())
        renderPreview(SpacePreview{}, PreviewOptions{});  // throws, with what to install
    if (recipe.cut) {
        if constexpr (Dim == 2)
            throw ParameterError("`preview.cut`: a plane is flat already; leave it out");
        else
            checkPreviewCut(*recipe.cut, domain.bounds());
    }
    if (pack && recipe.color == PreviewColor::order && pack->order.size() != pack->spheres.size())
        throw ParameterError(
            "`preview.color` order: the pack has no order of placement; color by radius");
}

template <int Dim>
PreviewPicture drawPreview(const PreviewRecipe& recipe, const std::string& reportFile,
                           const DomainSource& source, const DomainSource::Built& built,
                           const MadeVoids<Dim>& made, const Pack<Dim>* pack,
                           const Callbacks& callbacks, const TriangleMesh* wall) {
    if (recipe.file.empty() && (!isPage(reportFile) || (Dim == 3 && !canDrawSpace()))) return {};
    PreviewOptions options = optionsOf(recipe);
    options.cancelled = callbacks.cancelled;
    if (options.color == PreviewColor::column &&
        !(pack && columnOfNumbers(*pack, recipe.column.c_str()))) {
        callbacks.warn("`preview.color` " + recipe.column +
                       ": there is no such column of numbers; the picture is colored by radius");
        options.color = PreviewColor::radius;
    }
    if (recipe.file.empty()) {
        options.width = kPageWidth;
        options.height = kPageHeight;
    }
    return finished(draw(options, source, built, made, pack, wall), recipe, source.recipe().source);
}

template <int Dim>
bool drawGiven(const PreviewRecipe& recipe, const std::string& name, const Pack<Dim>& pack,
               const DomainSource* source, const DomainSource::Built& built) {
    if (recipe.file.empty()) return false;
    const PreviewOptions options = optionsOf(recipe);
    if (source) {
        finished(draw(options, *source, built, MadeVoids<Dim>{}, &pack, nullptr), recipe, name);
        return true;
    }
    std::conditional_t<Dim == 3, SpacePreview, PlanePreview> scene;
    scene.pack = &pack;
    finished(renderPreview(scene, options), recipe, name);
    return true;
}

bool drawGiven(const PreviewRecipe& recipe, const std::string& name, const TriangleMesh& solid) {
    if (recipe.file.empty()) return false;
    SpacePreview scene;
    scene.solid = &solid;
    finished(renderPreview(scene, optionsOf(recipe)), recipe, name);
    return true;
}

template void checkPreview<2>(const PreviewRecipe&, const Domain<2>&, const Pack<2>*);
template void checkPreview<3>(const PreviewRecipe&, const Domain<3>&, const Pack<3>*);
template bool drawGiven<2>(const PreviewRecipe&, const std::string&, const Pack<2>&,
                           const DomainSource*, const DomainSource::Built&);
template bool drawGiven<3>(const PreviewRecipe&, const std::string&, const Pack<3>&,
                           const DomainSource*, const DomainSource::Built&);
template PreviewPicture drawPreview<2>(const PreviewRecipe&, const std::string&,
                                       const DomainSource&, const DomainSource::Built&,
                                       const MadeVoids<2>&, const Pack<2>*, const Callbacks&,
                                       const TriangleMesh*);
template PreviewPicture drawPreview<3>(const PreviewRecipe&, const std::string&,
                                       const DomainSource&, const DomainSource::Built&,
                                       const MadeVoids<3>&, const Pack<3>*, const Callbacks&,
                                       const TriangleMesh*);

}  // namespace vdbpack
