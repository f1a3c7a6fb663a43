#include "vdbpack/core/error.h"
#include "vdbpack/core/version.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/report/markup.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/run/given_solid.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/run.h"
#include "vdbpack/view/pack_view.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Triangles of the solids in a page, which has some 12 bytes a triangle.
constexpr std::size_t kMostTriangles = 600'000;

/// Pages are passed on: they do not name folders.
std::string fileNameOf(const std::string& path) {
    return std::filesystem::path(filePart(path)).filename().string();
}

/// The file's name without folder and extensions.
std::string stemOf(const std::string& pack) {
    std::string name = fileNameOf(pack);
    const auto end = name.find('.', 1);
    return end == std::string::npos ? name : name.substr(0, end);
}

/// Writes the page, and tells so in the result, which has kind and count.
/// @param facts  about what is shown, for a line under the title
void writePage(const ViewRecipe& recipe, const std::string& facts, const PagePicture& picture,
               ViewResult& result) {
    const std::string title =
        fmt::format("{}: {} {}", fileNameOf(recipe.pack), grouped(result.count), result.kind);
    std::string main = "<h1>" + escaped(title) + "</h1>\n<p class='under'>" +
                       escaped(fmt::format("vdb_pack {}; {}; lengths in mm", version(), facts)) +
                       "</p>\n" + pictureFigure(picture);
    if (!recipe.command.empty())
        main += "<details><summary>How this page was made</summary><pre>vdb_pack " +
                escaped(recipe.command) + "</pre></details>\n";
    const std::string page = htmlPage(title, picture.viewStyle, main);
    OutputFile file(recipe.reportFile);
    file.write(page);
    file.commit();
    result.file = recipe.reportFile;
    result.bytes = page.size();
}

template <int Dim>
void view(const ViewRecipe& recipe, const DomainRecipe& domain, const Pack<Dim>& pack,
          ViewResult& result, const Callbacks& callbacks) {
    const RadiusStatistics radius = radiusStatistics(pack.spheres);
    const auto source = domainAround(domain, Dim, callbacks);
    if (source) requireSameAxes(recipe.pack, pack.origin, *source);
    const auto built =
        buildAround(source, Dim, radius, pack.spheres.size(), radius.max, recipe, callbacks);
    if (source) {
        Box<Dim> spheres;
        for (const auto& s : pack.spheres) spheres.add(s.center);
        if (intersection(spheres, ofDim<Dim>(built)->bounds()).empty())
            callbacks.warn(fmt::format(
                "{}: all {} lie outside of `domain` {}; check that the pack belongs to it, and "
                "that `unit` and `packUnit` are right",
                recipe.pack, Measure<Dim>::kSpheres, domain.source));
    }
    callbacks.stopIfCancelled();
    PagePicture picture =
        drawPack(recipe.preview, recipe.pack, pack, source ? &*source : nullptr, built, callbacks);
    addView(recipe.preview, source ? &*source : nullptr, built, pack, nullptr, true, picture);
    callbacks.stopIfCancelled();
    result.kind = Measure<Dim>::kSpheres;
    result.count = pack.spheres.size();
    const std::string wall =
        recipe.domain.source.empty() ? "" : ", wall of " + fileNameOf(recipe.domain.source);
    writePage(recipe, fmt::format("radius {:.4g} to {:.4g} mm{}", radius.min, radius.max, wall),
              picture, result);
}

/// The surface of a solid, of fewer triangles where it has more than its share of a page.
TriangleMesh shownSurface(GivenSolid& solid, std::size_t most, std::string& words) {
    const TriangleMesh& mesh = solid.surface();
    if (mesh.triangles.size() <= most) return mesh;
    TriangleMesh coarse;
    try {
        const auto levelSet = solid.levelSet();
        for (const double adaptivity : {0.05, 0.2, 0.5, 1.0}) {
            coarse = levelSetMesh(*levelSet, solid.name(), adaptivity);
            if (coarse.triangles.size() <= most) break;
        }
        words = fmt::format(
            "; the surface as a contour in voxels of {:.2g} mm, with triangles of "
            "different sizes",
            voxelSizeOf(*levelSet));
    } catch (const InputError&) {  // an open mesh has no level set
        return mesh;
    }
    return coarse;
}

void viewSolids(const ViewRecipe& recipe, ViewResult& result, const Callbacks& callbacks) {
    std::vector<GivenSolid> solids = givenSolids(recipe, result.found, callbacks);
    TriangleMesh surface;
    std::vector<std::pair<std::string, std::size_t>> parts;
    std::string words;
    for (GivenSolid& solid : solids) {
        const TriangleMesh mesh = shownSurface(solid, kMostTriangles / solids.size(), words);
        parts.emplace_back(solid.name(), mesh.triangles.size());
        append(surface, mesh);
    }
    callbacks.stopIfCancelled();
    const PreviewOptions options = inWorldOf(solids.front().source(), recipe.preview);
    PagePicture picture = drawSolid(options, recipe.pack, surface, callbacks);
    addView(options, surface, parts, picture);
    const Vec<3> size = surface.bounds().size();
    result.kind = "triangles";
    result.count = surface.triangles.size();
    std::string facts =
        fmt::format("{:.4g} x {:.4g} x {:.4g} mm{}", size[0], size[1], size[2], words);
    for (const FoundValue& found : result.found) facts += "; " + textOf(found);
    writePage(recipe, facts, picture, result);
}

}  // namespace

ViewResult runView(const ViewRecipe& asked, const Callbacks& callbacks) {
    ViewRecipe recipe = asked;
    if (recipe.reportFile.empty()) recipe.reportFile = stemOf(recipe.pack) + ".view.html";
    if (!isPage(recipe.reportFile))
        throw ParameterError(recipe.reportFile +
                             ": a view is a page for the browser; name it .html");
    recipe.preview.file.clear();
    checkSettings(recipe, RunKind::convert, {}, inputFiles(recipe));
    ViewResult result;
    std::vector<std::string> warnings;
    const Callbacks heard = keepingWarnings(withinMemory(callbacks, recipe.memoryLimit), warnings);
    withThreads(recipe.threads, [&] {
        const std::optional<Pack<3>> read = packUnlessSolid(recipe, heard);
        if (!read) return viewSolids(recipe, result, heard);
        requireDomain(recipe);
        if (recipe.domain.source.empty() && !recipe.domain.gridName.empty())
            throw ParameterError("`gridName` " + recipe.domain.gridName +
                                 ": names a level set of the `domain`, and there is none; set it");
        const Pack<3>& pack = *read;
        const DomainRecipe domain = domainOf(recipe, pack);
        if (isPlane(pack))
            view(recipe, domain, asCircles(pack), result, heard);
        else
            view(recipe, domain, pack, result, heard);
    });
    result.warnings = std::move(warnings);
    return result;
}

}  // namespace vdbpack
