// The view of a pack in a page.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/report/page_frame.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Adds a view of a pack, with the colors and the cut of the picture at first.
/// @param source  of its domain, whose wall is shown as well; null: none. @param built from it
/// @param wall    of it, if known already. @param large  whether it fills the window
template <int Dim>
void addView(const PreviewOptions& recipe, const DomainSource* source,
             const DomainSource::Built& built, const Pack<Dim>& pack, const TriangleMesh* wall,
             bool large, PagePicture& picture);

/// The same of solids. @param surface  of all, in the order of `solids`, each with a name and its
/// number of triangles
void addView(const PreviewOptions& recipe, const TriangleMesh& surface,
             const std::vector<std::pair<std::string, std::size_t>>& solids, PagePicture& picture);

}  // namespace vdbpack
