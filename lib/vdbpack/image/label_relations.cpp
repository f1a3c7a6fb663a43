#include "vdbpack/image/label_relations.h"

#include "vdbpack/core/disjoint_sets.h"

#include <algorithm>
#include <map>
#include <utility>

namespace vdbpack {

namespace {

/// Voxels of one label, one after another in a row.
struct Stretch {
    std::size_t begin, end;
    std::size_t label;  // in the list
    std::uint32_t piece;
};
using Row = std::vector<Stretch>;

/// Stretches of one label that touch are in one set.
struct Pieces {
    DisjointSets sets;
    std::vector<std::size_t> labels;  // of each member
};

/// Relates the labels of one layer, row by row.
class Relations {
public:
    Relations(std::size_t rows, Pieces& pieces) : above_(rows), pieces_(pieces) {}
    /// @param at  the row's place in its slice.
    void add(Row row, std::size_t at) {
        for (Stretch& s : row) {
            s.piece = pieces_.sets.add();
            pieces_.labels.push_back(s.label);
        }
        for (std::size_t k = 1; k < row.size(); ++k)
            if (row[k - 1].end == row[k].begin) touch(row[k - 1], row[k], 1);
        if (at > 0) relate(above_[at - 1], row);  // this slice's, by now
        relate(above_[at], row);                  // that of the slice before
        above_[at] = std::move(row);
    }
    const std::map<std::pair<std::size_t, std::size_t>, std::size_t>& faces() const {
        return faces_;
    }

private:
    void relate(const Row& a, const Row& b) {
        auto i = a.begin(), j = b.begin();
        while (i != a.end() && j != b.end()) {
            const std::size_t begin = std::max(i->begin, j->begin);
            const std::size_t end = std::min(i->end, j->end);
            if (begin < end) touch(*i, *j, end - begin);
            if (i->end < j->end)
                ++i;
            else
                ++j;
        }
    }
    void touch(const Stretch& a, const Stretch& b, std::size_t faces) {
        if (a.label == b.label)
            pieces_.sets.join(a.piece, b.piece);
        else
            faces_[std::minmax(a.label, b.label)] += faces;
    }

    std::vector<Row> above_;
    Pieces& pieces_;
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> faces_;
};

}  // namespace

LabelRelations labelRelations(const Image& image, const std::vector<LabelCount>& labels) {
    LabelRelations result;
    result.components.resize(labels.size());
    const auto& size = image.grid.size;
    Pieces pieces;
    for (std::size_t layer = 0; layer < image.layers; ++layer) {
        std::map<std::int64_t, std::size_t> indices;
        for (std::size_t i = 0; i < labels.size(); ++i)
            if (labels[i].layer == layer) indices[labels[i].value] = i;
        Relations relations(size[1], pieces);
        image.visit([&](const auto* numbers) {
            for (std::size_t z = 0; z < size[2]; ++z)
                for (std::size_t y = 0; y < size[1]; ++y) {
                    const auto* const at =
                        numbers + (z * size[1] + y) * size[0] * image.layers + layer;
                    Row row;
                    for (std::size_t x = 0; x < size[0];) {
                        const auto number = at[x * image.layers];
                        std::size_t end = x + 1;
                        while (end < size[0] && at[end * image.layers] == number) ++end;
                        const auto value = static_cast<std::int64_t>(image.value(number));
                        if (value != 0) row.push_back({x, end, indices.at(value), 0});
                        x = end;
                    }
                    relations.add(std::move(row), y);
                }
        });
        for (const auto& [pair, faces] : relations.faces())
            result.contacts.push_back({pair.first, pair.second, faces});
    }
    for (std::uint32_t i = 0; i < pieces.labels.size(); ++i)
        if (pieces.sets.find(i) == i) ++result.components[pieces.labels[i]];
    return result;
}

}  // namespace vdbpack
