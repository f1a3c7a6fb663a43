#include "vdbpack/run/rank_stages.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/pack_parts.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/voids/thinning.h"

#include <fmt/format.h>

namespace vdbpack {

namespace {

void refuse(bool wanted, const char* what, const char* instead) {
    if (wanted)
        throw ParameterError(
            fmt::format("{}: is not done over several processes; {}", what, instead));
}

}  // namespace

void checkRanksIn(const DomainSource& source, const PackRecipe& recipe) {
    if (!source.isPeriodic()) return;
    refuse(isPage(recipe.reportFile), "a page of a periodic cell", "write a report as .json");
}

void checkRanks(const PackRecipe& recipe) {
    const char* const alone = "leave it out, or start one process with all threads";
    refuse(recipe.densify.fraction > 0 && !recipe.existing.empty(),
           "`densify` around `existing` spheres", alone);
    refuse(recipe.images, "`images` of a periodic cell", "convert a file that was written");
    refuse(recipe.voids.keepConnected, "`keepConnected`", alone);
    refuse(recipe.voids.as<Thinning>() || recipe.voids.as<FrontHoles>(),
           "`voids` chosen among the spheres",
           "use voids such as boolean, overlay, grid or a list");
    const PreviewOptions& preview = recipe.preview;
    refuse(!preview.file.empty() || preview.cut || preview.color != PreviewColor::radius,
           "a picture", "draw it from a file that was written");
    for (const OutputTarget& output : recipe.outputs) {
        const OutputKind kind = output.kind;
        if (kind == OutputKind::pack) checkShareFormat(output.text);
        refuse(kind == OutputKind::contacts || kind == OutputKind::materials ||
                   kind == OutputKind::labels || kind == OutputKind::blender,
               output.text.c_str(), "write it from a file of the spheres");
    }
}

template <int Dim>
SphereRows rowsOf(const Run<Dim>& run) {
    if (!run.ranks()) return {};
    SphereRows all{run.ranks(), std::vector<std::int64_t>(run.pack.spheres.size())};
    for (const RowSpan& span : run.share.spans)
        for (std::size_t i = span.begin; i < span.end; ++i)
            all.rows[i] = static_cast<std::int64_t>(span.row + (i - span.begin));
    return all;
}

template SphereRows rowsOf(const Run<2>&);
template SphereRows rowsOf(const Run<3>&);

}  // namespace vdbpack
