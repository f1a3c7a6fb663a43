// Private to runs: solids in place of packs.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/report/report.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The spheres of a run's pack, or nothing if it is a solid: as `readInputPackUnlessSolid`, an
/// image by its name, a shape, or fog with a threshold.
std::optional<Pack<3>> packUnlessSolid(const InputPack& recipe, const Callbacks& callbacks);

/// A mesh, what is taken of an image, a level set, a fog volume, a shape, or what clips leave of
/// it.
class GivenSolid {
public:
    /// @param settings, callbacks  must outlive it.
    GivenSolid(std::string name, std::shared_ptr<const DomainSource> source,
               const InputPack& settings, const Callbacks& callbacks);

    const std::string& name() const { return name_; }
    const DomainSource& source() const { return *source_; }
    /// The triangles of a file or an image as they are, the faces of a box, or else a contour of
    /// the level set.
    const TriangleMesh& surface();
    /// That of a file, or one in voxels of the size that was requested, or else of 1/256 of the
    /// longest side. @throws as DomainSource::build, ResourceError
    std::shared_ptr<const VdbGrid> levelSet() const;

private:
    std::string name_;
    std::shared_ptr<const DomainSource> source_;
    const InputPack& settings_;
    const Callbacks& callbacks_;
    TriangleMesh made_;
};

/// What `recipe.pack` is, read by the settings of `recipe.domain`, which names no domain of its
/// own: several solids where a label map is read with several labels.
/// @param found  gets the threshold. @throws as DomainSource; ParameterError for what is plane
std::vector<GivenSolid> givenSolids(const InputPack& recipe, FoundValues& found,
                                    const Callbacks& callbacks);

/// The surfaces of all.
TriangleMesh joinedSurface(std::vector<GivenSolid>& solids);

}  // namespace vdbpack
