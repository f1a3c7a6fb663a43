#include "vdbpack/domain/label_domains.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"

#include <fmt/format.h>

namespace vdbpack {

LabelledImage::LabelledImage(const DomainRecipe& domain, const Callbacks& callbacks)
    : image_(readDomainImage(domain, callbacks)),
      labels_(requiredLabels(domain, image_, callbacks)),
      path_(domain.source) {}

std::vector<LabelPart> LabelledImage::parse(const std::string& text) const {
    return parseLabels(text, labels_, path_);
}

std::size_t LabelledImage::add(const LabelPart& part) {
    for (const LabelCount& label : part.labels)
        if (!used_.insert({label.layer, label.value}).second)
            throw ParameterError(fmt::format("{}: label {} is in two parts", path_, label.value));
    parts_.push_back(part);
    return parts_.size() - 1;
}

void LabelledImage::makeSurfaces(const Callbacks& callbacks) {
    warnOfBorder(parts_, image_.grid, path_, callbacks);
    surfaces_.resize(parts_.size());
    std::map<std::size_t, std::vector<std::size_t>> layers;
    for (std::size_t p = 0; p < parts_.size(); ++p) layers[layerOf(p)].push_back(p);
    for (const auto& [layer, members] : layers) {
        std::vector<LabelPart> some;
        for (const std::size_t p : members) some.push_back(parts_[p]);
        auto meshes = labelSurfaces(image_, labels_, some);
        for (std::size_t k = 0; k < members.size(); ++k)
            surfaces_[members[k]] = std::move(meshes[k]);
    }
    image_.bytes.reset();
}

DomainSource LabelledImage::source(const DomainRecipe& domain, std::size_t part,
                                   const Callbacks& callbacks) {
    const LabelPart& one = parts_[part];
    warnOfVolume(surfaces_[part], image_.grid, one.voxels(), path_ + ": label " + one.name,
                 callbacks);
    DomainSource made(domain, std::move(surfaces_[part]), callbacks);
    made.setImageGrid(image_.grid, image_.isSpaced, image_.isSided);
    return made;
}

LabelledImage& LabelledImages::of(const DomainRecipe& domain) {
    const Key key{domain.source,
                  domain.mask,
                  domain.image,
                  domain.voxelSpacing.value_or(Vec<3>{}).c,
                  domain.unit,
                  domain.scale,
                  domain.space,
                  domain.pose.file,
                  domain.pose.matrix,
                  domain.pose.rotate,
                  domain.pose.translate.value_or(Vec<3>{}).c};
    const auto known = images_.find(key);
    if (known != images_.end()) return known->second;
    return images_.emplace(key, LabelledImage(domain, callbacks_)).first->second;
}

void LabelledImages::makeSurfaces() {
    for (auto& [key, image] : images_) image.makeSurfaces(callbacks_);
}

}  // namespace vdbpack
