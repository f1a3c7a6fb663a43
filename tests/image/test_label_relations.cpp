#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/image/label_relations.h"

TEST_CASE("components and contacts of labels are those of a search voxel by voxel") {
    Image image;
    image.grid.size = {13, 9, 11};
    image.type = NumberType::u8;
    const std::size_t count = image.grid.voxels();
    image.bytes = voxelMemory(count);
    auto* const values = reinterpret_cast<std::uint8_t*>(image.bytes.get());
    RandomStream random(5, GENERATE(1, 2, 3));
    for (std::size_t i = 0; i < count; ++i)
        values[i] =
            static_cast<std::uint8_t>(random.uniform() < 0.4 ? 0 : 1 + 4 * random.uniform());

    std::map<int, std::size_t> components;
    std::map<std::pair<int, int>, std::size_t> faces;
    std::vector<bool> seen(count);
    const std::size_t stride[3] = {1, 13, 13 * 9};
    const auto forNeighbors = [&](std::size_t i, const auto& work) {
        for (std::size_t d = 0; d < 3; ++d) {
            const std::size_t at = i / stride[d] % image.grid.size[d];
            if (at > 0) work(i - stride[d]);
            if (at + 1 < image.grid.size[d]) work(i + stride[d]);
        }
    };
    for (std::size_t i = 0; i < count; ++i) {
        forNeighbors(i, [&](std::size_t j) {
            if (values[i] && values[j] && values[i] < values[j]) ++faces[{values[i], values[j]}];
        });
        if (values[i] == 0 || seen[i]) continue;
        ++components[values[i]];
        std::vector<std::size_t> next{i};
        seen[i] = true;
        while (!next.empty()) {
            const std::size_t k = next.back();
            next.pop_back();
            forNeighbors(k, [&](std::size_t j) {
                if (values[j] != values[k] || seen[j]) return;
                seen[j] = true;
                next.push_back(j);
            });
        }
    }
    const auto labels = *labelsOf(image);
    const LabelRelations found = labelRelations(image, labels);
    REQUIRE(labels.size() == components.size());
    for (std::size_t i = 0; i < labels.size(); ++i)
        CHECK(found.components[i] == components.at(static_cast<int>(labels[i].value)));
    REQUIRE(found.contacts.size() == faces.size());
    for (const LabelContact& contact : found.contacts)
        CHECK(contact.faces == faces.at({static_cast<int>(labels[contact.first].value),
                                         static_cast<int>(labels[contact.second].value)}));
}
