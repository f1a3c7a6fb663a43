// Private to runs: pictures of their results.
#pragma once

#include "vdbpack/preview/preview_recipe.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/make_voids.h"

#include <optional>
#include <string>

namespace vdbpack {

/// Refuses requests that cannot be drawn, before anything is read. @throws ParameterError
void checkPreview(const PreviewRecipe& recipe, const std::string& reportFile);

/// The same once the domain is known: a cut beside it or in a plane, a build without Embree.
/// @param pack  what will be drawn, where it is there already; null: still to be packed, or none.
/// @throws ParameterError
template <int Dim>
void checkPreview(const PreviewRecipe& recipe, const Domain<Dim>& domain, const Pack<Dim>* pack);

/// Draws the result of a run, if `recipe` names a file, which is then written, or if the report is
/// a page (without a file, the picture is smaller). Without Embree, a page has no picture of
/// spheres.
/// @param pack  null: the solid that `made` leaves is drawn.
/// @throws as `renderPreview`, `writePng`
template <int Dim>
PagePicture drawPreview(const PreviewRecipe& recipe, const std::string& reportFile,
                        const DomainSource& source, const DomainSource::Built& built,
                        const MadeVoids<Dim>& made, const Pack<Dim>* pack,
                        const Callbacks& callbacks, const TriangleMesh* wall = nullptr);

/// Adds a view of a pack, with the colors and the cut of the picture at first.
/// @param source  of its domain, whose wall is shown as well; null: none. @param built from it
/// @param wall    of it, if known already. @param large  whether it fills the window
template <int Dim>
void addView(const PreviewRecipe& recipe, const DomainSource* source,
             const DomainSource::Built& built, const Pack<Dim>& pack, const TriangleMesh* wall,
             bool large, PagePicture& picture);

/// Draws a pack that was read, for a page unless `recipe` names a file, which is then written.
/// Without Embree, a page has no picture of spheres.
/// @param name    of the pack's file, kept in the picture.
/// @param source  of its domain, whose wall is drawn as well; null: none. @param built from it
/// @throws as `drawPreview`
template <int Dim>
PagePicture drawPack(const PreviewRecipe& recipe, const std::string& name, const Pack<Dim>& pack,
                     const DomainSource* source, const DomainSource::Built& built,
                     const Callbacks& callbacks);

/// The same, only if `recipe` names a file.
/// @return whether a file was written.  @throws as `drawPreview`
template <int Dim>
bool drawGiven(const PreviewRecipe& recipe, const std::string& name, const Pack<Dim>& pack,
               const DomainSource* source, const DomainSource::Built& built);

/// The same of a closed surface. @throws as `drawPreview`
bool drawGiven(const PreviewRecipe& recipe, const std::string& name, const TriangleMesh& solid);

}  // namespace vdbpack
