#include "vdbpack/core/error.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/markup.h"
#include "vdbpack/report/page_frame.h"
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

std::string pageOf(const ViewRecipe& recipe, const std::string& things, std::size_t count,
                   const RadiusStatistics& radius, const PagePicture& picture) {
    const std::string title =
        fmt::format("{}: {} {}", fileNameOf(recipe.pack), grouped(count), things);
    const std::string wall =
        recipe.domain.source.empty() ? "" : ", wall of " + fileNameOf(recipe.domain.source);
    std::string main = "<h1>" + escaped(title) + "</h1>\n<p class='under'>" +
                       escaped(fmt::format("vdb_pack {}; radius {:.4g} to {:.4g} mm{}; lengths in "
                                           "mm",
                                           VDBPACK_VERSION, radius.min, radius.max, wall)) +
                       "</p>\n" + pictureFigure(picture);
    if (!recipe.command.empty())
        main += "<details><summary>How this page was made</summary><pre>vdb_pack " +
                escaped(recipe.command) + "</pre></details>\n";
    return htmlPage(title, picture.viewStyle, main);
}

template <int Dim>
void view(const ViewRecipe& recipe, const DomainRecipe& domain, const Pack<Dim>& pack,
          ViewResult& result, const Callbacks& callbacks) {
    const RadiusStatistics radius = radiusStatistics(pack.spheres);
    const auto source = domainAround(domain, Dim, callbacks);
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
    const std::string page = pageOf(recipe, result.kind, pack.spheres.size(), radius, picture);
    OutputFile file(recipe.reportFile);
    file.write(page);
    file.commit();
    result.file = recipe.reportFile;
    result.bytes = page.size();
}

}  // namespace

ViewResult runView(const ViewRecipe& asked, const Callbacks& callbacks) {
    ViewRecipe recipe = asked;
    if (recipe.reportFile.empty()) recipe.reportFile = stemOf(recipe.pack) + ".view.html";
    if (!isPage(recipe.reportFile))
        throw ParameterError(recipe.reportFile +
                             ": a view is a page for the browser; name it .html");
    requireDomain(recipe);
    if (recipe.domain.source.empty() && !recipe.domain.gridName.empty())
        throw ParameterError("`gridName` " + recipe.domain.gridName +
                             ": names a level set of the `domain`, and there is none; set it");
    recipe.preview.file.clear();
    checkSettings(recipe, RunKind::convert, {}, inputFiles(recipe));
    ViewResult result;
    std::vector<std::string> warnings;
    const Callbacks heard = keepingWarnings(withinMemory(callbacks, recipe.memoryLimit), warnings);
    withThreads(recipe.threads, [&] {
        const std::optional<Pack<3>> read = readInputPackUnlessSolid(recipe, heard);
        if (!read)
            throw InputError(recipe.pack +
                             ": is a mesh or a level set, and a view shows spheres. Fill it "
                             "(vdb_pack pack), or show it around a pack with `domain`");
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
