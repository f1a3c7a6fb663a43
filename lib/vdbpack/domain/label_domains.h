// Domains from several labels of one image, whose surfaces share their triangles.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/image_surface.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace vdbpack {

/// An image that parts are labels of, and their surfaces.
class LabelledImage {
public:
    /// @throws as `readDomainImage`; ParameterError if it is no label map
    LabelledImage(const DomainRecipe& domain, const Callbacks& callbacks);

    /// As `parseLabels`.
    std::vector<LabelPart> parse(const std::string& text) const;
    /// Adds a part and returns its number. @throws ParameterError if a label is in two parts
    std::size_t add(const LabelPart& part);
    /// Makes the surfaces of all parts, those of a layer together.
    void makeSurfaces(const Callbacks& callbacks);
    /// The domain of a part, once.
    DomainSource source(const DomainRecipe& domain, std::size_t part, const Callbacks& callbacks);
    std::size_t layerOf(std::size_t part) const { return parts_[part].labels.front().layer; }

private:
    Image image_;
    std::vector<LabelCount> labels_;
    std::string path_;
    std::vector<LabelPart> parts_;
    std::set<std::pair<std::size_t, std::int64_t>> used_;
    std::vector<TriangleMesh> surfaces_;
};

/// The images of some domains, each read once.
class LabelledImages {
public:
    /// @param callbacks  must outlive this.
    explicit LabelledImages(const Callbacks& callbacks) : callbacks_(callbacks) {}

    LabelledImage& of(const DomainRecipe& domain);
    void makeSurfaces();

private:
    /// What recipes that read the same image in the same way have in common.
    using Key = std::tuple<std::string, std::string, std::shared_ptr<const Image>,
                           std::array<double, 3>, Unit, double, ImageSpace, std::string,
                           std::vector<double>, std::vector<double>, std::array<double, 3>>;

    const Callbacks& callbacks_;
    std::map<Key, LabelledImage> images_;
};

/// The surface of a part among the labels of an image.
struct LabelPlace {
    LabelledImage* image = nullptr;  ///< null: the part is no label
    std::size_t part = 0;

    bool sharesLayerWith(const LabelPlace& other) const {
        return image && image == other.image && image->layerOf(part) == image->layerOf(other.part);
    }
};

}  // namespace vdbpack
