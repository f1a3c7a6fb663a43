// Pictures of their results.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/voids/make_voids.h"

#include <optional>
#include <string>

namespace vdbpack {

/// Refuses requests that cannot be drawn, before anything is read. @throws ParameterError
void checkPreview(const PreviewOptions& recipe, const std::string& reportFile);

/// The same once the domain is known: a cut beside it or in a plane, a build without Embree.
/// @param pack  what will be drawn, where it is there already; null: still to be packed, or none.
/// @throws ParameterError
template <int Dim>
void checkPreview(const PreviewOptions& recipe, const Domain<Dim>& domain, const Pack<Dim>* pack);

/// The options with the axes of the world of a domain.
PreviewOptions inWorldOf(const DomainSource& source, PreviewOptions options);
/// The same of a pack without a domain, by the axes that its file states.
PreviewOptions inWorldOf(const PackOrigin& origin, PreviewOptions options);

/// Draws the result of a run, if `recipe` names a file, which is then written, or if the report is
/// a page (without a file, the picture is smaller). Without Embree, a page has no picture of
/// spheres.
/// @param pack  null: the solid that `made` leaves is drawn.
/// @throws as `renderPreview`, `writePng`
template <int Dim>
PagePicture drawPreview(const PreviewOptions& recipe, const std::string& reportFile,
                        const DomainSource& source, const DomainSource::Built& built,
                        const MadeVoids<Dim>& made, const Pack<Dim>* pack,
                        const Callbacks& callbacks, const TriangleMesh* wall = nullptr);

/// Draws a pack that was read, for a page unless `recipe` names a file, which is then written.
/// Without Embree, a page has no picture of spheres.
/// @param name    of the pack's file, kept in the picture.
/// @param source  of its domain, whose wall is drawn as well; null: none. @param built from it
/// @throws as `drawPreview`
template <int Dim>
PagePicture drawPack(const PreviewOptions& recipe, const std::string& name, const Pack<Dim>& pack,
                     const DomainSource* source, const DomainSource::Built& built,
                     const Callbacks& callbacks);

/// The same, only if `recipe` names a file.
/// @return whether a file was written.  @throws as `drawPreview`
template <int Dim>
bool drawGiven(const PreviewOptions& recipe, const std::string& name, const Pack<Dim>& pack,
               const DomainSource* source, const DomainSource::Built& built);

/// As `drawPack`, of a closed surface.
PagePicture drawSolid(const PreviewOptions& recipe, const std::string& name,
                      const TriangleMesh& solid, const Callbacks& callbacks = {});
/// The same, only if `recipe` names a file.
bool drawGiven(const PreviewOptions& recipe, const std::string& name, const TriangleMesh& solid);

}  // namespace vdbpack
