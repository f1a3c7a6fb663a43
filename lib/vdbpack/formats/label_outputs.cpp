#include "vdbpack/formats/label_outputs.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/linear_sampler.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/output_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace vdbpack {

namespace {

/// The first output that is a label map; null: none.
const OutputTarget* labelOutput(const std::vector<OutputTarget>& outputs) {
    const auto found = std::find_if(outputs.begin(), outputs.end(), [](const OutputTarget& output) {
        return output.kind == OutputKind::labels;
    });
    return found == outputs.end() ? nullptr : &*found;
}

/// Whether the spacing of a domain's recipe is that of label maps, not of its image.
bool isForLabels(const DomainSource& source) {
    return source.recipe().voxelSpacing && (!source.imageGrid() || source.isSpaced());
}

ImageGrid chosenGrid(const std::string& output, const std::vector<const DomainSource*>& sources) {
    const auto image = std::find_if(sources.begin(), sources.end(),
                                    [](const auto* source) { return source->imageGrid(); });
    const DomainSource& source = image == sources.end() ? *sources.front() : **image;
    if (!isForLabels(source)) {
        if (source.imageGrid()) return *source.imageGrid();
        throw ParameterError(output +
                             ": no image says how large its voxels are; set `voxelSpacing`");
    }
    const Vec<3> spacing = *source.recipe().voxelSpacing;
    if (source.imageGrid()) return withSpacing(*source.imageGrid(), spacing);
    Box<3> box;
    for (const DomainSource* one : sources) {
        box.add(one->domainBounds().lo);
        box.add(one->domainBounds().hi);
    }
    return gridAround(box, spacing);
}

constexpr std::int64_t kMostLabel = std::numeric_limits<std::int32_t>::max();

/// The label of each sphere: what it is, counted from 1.
std::vector<std::int32_t> sphereLabels(const std::string& output, const std::string& what,
                                       const Pack<3>& pack) {
    const Materials materials(pack);
    if (what == "parts" && !materials.hasParts())
        throw ParameterError(output + ": the pack has no several parts; leave it out");
    if (what == "regions" && pack.region.empty())
        throw ParameterError(output + ": the pack has no regions; set `shell`, or leave it out");
    std::vector<std::int32_t> labels;
    labels.reserve(pack.spheres.size());
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const std::int64_t number = what == "regions"     ? pack.region[i]
                                    : what == "parts"     ? materials.partOf(i)
                                    : what == "materials" ? materials.of(i)
                                    : pack.id.empty()     ? static_cast<std::int64_t>(i)
                                                          : pack.id[i];
        if (number < 0 || number >= kMostLabel)
            throw ParameterError(fmt::format("{}: {} is no label; ids from 0 to {} are", output,
                                             number, kMostLabel - 1));
        labels.push_back(static_cast<std::int32_t>(number + 1));
    }
    return labels;
}

LabelMap solidLabels(const std::vector<SolidTest>& solids, const ImageGrid& grid) {
    return labelMapOf(
        [&]() -> std::function<std::int32_t(const Vec<3>&)> {
            std::vector<std::function<bool(const Vec<3>&)>> inside;
            for (const SolidTest& solid : solids) inside.push_back(solid());
            return [inside](const Vec<3>& x) {
                for (std::size_t part = inside.size(); part > 0; --part)
                    if (inside[part - 1](x)) return static_cast<std::int32_t>(part);
                return 0;
            };
        },
        grid);
}

}  // namespace

SolidTest solidTest(const std::shared_ptr<const Domain<3>>& domain) {
    return [domain]() -> std::function<bool(const Vec<3>&)> {
        const std::shared_ptr<DomainSampler<3>> sampler = domain->sampler();
        return [sampler](const Vec<3>& x) { return sampler->contains(x); };
    };
}

SolidTest solidTest(const std::shared_ptr<const VdbGrid>& levelSet) {
    return [levelSet]() -> std::function<bool(const Vec<3>&)> {
        const double voxel = voxelSizeOf(*levelSet);
        const auto sample =
            std::make_shared<LinearSampler<3>>(*levelSet, originOf(*levelSet), voxel, voxel);
        return [sample](const Vec<3>& x) { return (*sample)(x) < 0; };
    };
}

std::optional<ImageGrid> labelGridOf(const std::vector<OutputTarget>& outputs,
                                     const std::vector<const DomainSource*>& sources,
                                     double limit) {
    const OutputTarget* output = labelOutput(outputs);
    if (!output) return std::nullopt;
    if (sources.empty())
        throw ParameterError(output->text +
                             ": a label map covers a domain, and there is none; set `domain`");
    if (sources.front()->dim() != 3)
        throw ParameterError(output->text + ": label maps need a 3D domain; leave this output out");
    const ImageGrid grid = chosenGrid(output->text, sources);
    const double bytes = 5 * static_cast<double>(grid.voxels());
    if (residentMemory() + bytes > memoryLimit(limit))
        throw ResourceError(fmt::format(
            "{}: {} x {} x {} voxels take {}, more than there is; make `voxelSpacing` larger",
            output->text, grid.size[0], grid.size[1], grid.size[2], bytesText(bytes)));
    return grid;
}

void warnOfUnusedSpacing(const std::vector<OutputTarget>& outputs,
                         const std::vector<const DomainSource*>& sources,
                         const Callbacks& callbacks) {
    if (labelOutput(outputs) || sources.empty()) return;
    for (const DomainSource* source : sources)
        if (!isForLabels(*source)) return;
    const DomainSource& first = *sources.front();
    warnOfSpacing(first.recipe(), first.imageGrid().has_value(), callbacks);
}

void writeLabels(const OutputTarget& target, const Pack<3>* pack, const LabelSource& source,
                 const std::string& generator) {
    const std::string &output = target.text, &what = target.labels;
    if (!source.grid) throw ParameterError(output + ": this run has no 3D domain to label");
    if (what != "solid" && !pack)
        throw ParameterError(
            output + ": this run has no spheres; name it labels-solid:FILE to write the solid");
    LabelMap map = what == "solid"
                       ? solidLabels(source.solids, *source.grid)
                       : labelMapOf(pack->spheres, sphereLabels(output, what, *pack), *source.grid);
    if (source.space == ImageSpace::ras)
        for (int d = 0; d < 2; ++d) {
            map.grid.origin[d] *= -1;
            for (Vec<3>& step : map.grid.step) step[d] *= -1;
        }
    writeLabelMap(map, target.file, generator);
}

}  // namespace vdbpack
