#include "vdbpack/preview/result_picture.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/version.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/preview/drawn_wall.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/report/report.h"

#include <algorithm>
#include <type_traits>

namespace vdbpack {

PreviewOptions inWorldOf(const DomainSource& source, PreviewOptions options) {
    options.space = source.recipe().space;
    options.ofPatient = source.isSided();
    return options;
}

PreviewOptions inWorldOf(const PackOrigin& origin, PreviewOptions options) {
    if (origin.axes.empty()) return options;
    options.space = origin.axes == "RAS" ? ImageSpace::ras : ImageSpace::lps;
    options.ofPatient = true;
    return options;
}

namespace {

constexpr int kPageWidth = 960;  // or the height, of what is higher than wide

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
    const PlaneField field = planeField(*built.plane, pack ? nullptr : made.stamped.get(),
                                        std::max(options.width, options.height));
    PlanePreview scene;
    scene.pack = pack;
    scene.field = &field;
    scene.bounds = built.plane->bounds();
    return renderPreview(scene, options);
}

/// Encodes a picture, and writes it if it has a file.
PagePicture finished(Picture image, const PreviewOptions& recipe, const std::string& source) {
    PagePicture picture;
    for (const auto& [keyword, text] : image.texts)
        picture.words += (picture.words.empty() ? "" : ", ") + text;
    image.texts.emplace_back("Software", std::string("vdb_pack ") + version());
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

/// The options of a picture that is written, or of a page; nothing where a page has none.
template <int Dim>
std::optional<PreviewOptions> optionsFor(const PreviewOptions& recipe, const Callbacks& callbacks) {
    PreviewOptions options = recipe;
    options.cancelled = callbacks.cancelled;
    if (!recipe.file.empty()) return options;
    if (Dim == 3 && !canDrawSpace()) return std::nullopt;
    options.width = kPageWidth;
    options.height = 0;
    return options;
}

}  // namespace

void checkPreview(const PreviewOptions& recipe, const std::string& reportFile) {
    checkPreviewSize(recipe.width, recipe.height);
    const std::string& file = recipe.file;
    if (!file.empty() && extensionOf(file) != ".png")
        throw ParameterError("`preview.file` " + file + ": pictures are PNG; name it .png");
    facingCut(recipe);
    const char* const asked = recipe.cut                             ? "`preview.cut`"
                              : recipe.view                          ? "`preview.view`"
                              : recipe.color != PreviewColor::chosen ? "`preview.color`"
                                                                     : nullptr;
    if (asked && file.empty() && !isPage(reportFile))
        throw ParameterError(std::string(asked) +
                             " has no effect without a picture; add `preview.file` FILE.png or "
                             "`reportFile` FILE.html");
}

template <int Dim>
void checkPreview(const PreviewOptions& recipe, const Domain<Dim>& domain, const Pack<Dim>* pack) {
    if (Dim == 3 && !recipe.file.empty() && !canDrawSpace())
        renderPreview(SpacePreview{}, PreviewOptions{});  // throws, with what to install
    if constexpr (Dim == 2)
        refuseInPlane(recipe);
    else if (recipe.cut)
        checkPreviewCut(*recipe.cut, domain.bounds());
    if (pack && recipe.color == PreviewColor::order && pack->order.size() != pack->spheres.size())
        throw ParameterError(
            "`preview.color` order: the pack has no order of placement; color by radius");
}

template <int Dim>
PagePicture drawPreview(const PreviewOptions& recipe, const std::string& reportFile,
                        const DomainSource& source, const DomainSource::Built& built,
                        const MadeVoids<Dim>& made, const Pack<Dim>* pack,
                        const Callbacks& callbacks, const TriangleMesh* wall) {
    if (recipe.file.empty() && (!isPage(reportFile) || (Dim == 3 && !canDrawSpace()))) return {};
    PreviewOptions options = recipe;
    options.cancelled = callbacks.cancelled;
    if (options.color == PreviewColor::column &&
        !(pack && columnOfNumbers(*pack, recipe.column.c_str()))) {
        callbacks.warn("`preview.color` " + recipe.column +
                       ": there is no such column of numbers; the picture is colored by radius");
        options.color = PreviewColor::radius;
    }
    if (recipe.file.empty()) {
        options.width = kPageWidth;
        options.height = 0;
    }
    return finished(draw(inWorldOf(source, options), source, built, made, pack, wall), recipe,
                    source.recipe().source);
}

template <int Dim>
PagePicture drawPack(const PreviewOptions& recipe, const std::string& name, const Pack<Dim>& pack,
                     const DomainSource* source, const DomainSource::Built& built,
                     const Callbacks& callbacks) {
    const auto options = optionsFor<Dim>(recipe, callbacks);
    if (!options) return {};
    if (source)
        return finished(
            draw(inWorldOf(*source, *options), *source, built, MadeVoids<Dim>{}, &pack, nullptr),
            recipe, name);
    std::conditional_t<Dim == 3, SpacePreview, PlanePreview> scene;
    scene.pack = &pack;
    return finished(renderPreview(scene, inWorldOf(pack.origin, *options)), recipe, name);
}

template <int Dim>
bool drawGiven(const PreviewOptions& recipe, const std::string& name, const Pack<Dim>& pack,
               const DomainSource* source, const DomainSource::Built& built) {
    if (recipe.file.empty()) return false;
    drawPack(recipe, name, pack, source, built, {});
    return true;
}

PagePicture drawSolid(const PreviewOptions& recipe, const std::string& name,
                      const TriangleMesh& solid, const Callbacks& callbacks) {
    SpacePreview scene;
    scene.solid = &solid;
    const auto options = optionsFor<3>(recipe, callbacks);
    return options ? finished(renderPreview(scene, *options), recipe, name) : PagePicture{};
}

bool drawGiven(const PreviewOptions& recipe, const std::string& name, const TriangleMesh& solid) {
    if (recipe.file.empty()) return false;
    drawSolid(recipe, name, solid);
    return true;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template void checkPreview<Dim>(const PreviewOptions&, const Domain<Dim>&, const Pack<Dim>*); \
    template PagePicture drawPack<Dim>(const PreviewOptions&, const std::string&,                 \
                                       const Pack<Dim>&, const DomainSource*,                     \
                                       const DomainSource::Built&, const Callbacks&);             \
    template bool drawGiven<Dim>(const PreviewOptions&, const std::string&, const Pack<Dim>&,     \
                                 const DomainSource*, const DomainSource::Built&);                \
    template PagePicture drawPreview<Dim>(const PreviewOptions&, const std::string&,              \
                                          const DomainSource&, const DomainSource::Built&,        \
                                          const MadeVoids<Dim>&, const Pack<Dim>*,                \
                                          const Callbacks&, const TriangleMesh*);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
