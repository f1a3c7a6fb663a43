#include "vdbpack/image/nrrd_grid.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/image_axes.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// The entries of a list: words, texts in quotes (without them) and vectors in parentheses.
std::vector<std::string> entriesOf(std::string_view text) {
    std::vector<std::string> entries;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const bool quoted = text.front() == '"', vector = text.front() == '(';
        std::size_t end = quoted   ? text.find('"', 1)
                          : vector ? text.find(')')
                                   : text.find_first_of(" \t");
        end = std::min(end, text.size());
        const std::size_t begin = quoted || vector ? 1 : 0;
        entries.emplace_back(trimmed(text.substr(begin, end - begin)));
        text.remove_prefix(std::min(end + begin, text.size()));
    }
    return entries;
}

double numberOf(const std::string& text) {
    double value = 0;
    return parseReal(text, value) ? value : std::numeric_limits<double>::quiet_NaN();
}

/// A vector of up to three numbers; a fourth one is that of time.
Vec<3> vectorOf(const std::string& text) {
    Vec<3> vector;
    const auto numbers = splitAt(text, ',');
    for (std::size_t d = 0; d < std::min<std::size_t>(3, numbers.size()); ++d)
        vector.c[d] = numberOf(numbers[d]);
    return vector;
}

/// The signs that turn a space to LPS; nothing for one that does not name the sides of a patient.
std::optional<Vec<3>> turnOf(std::string space) {
    space = lowered(space);
    if (endsWith(space, "-time")) space.resize(space.size() - 5);
    if (space.size() == 4 && space.back() == 't') space.pop_back();
    if (space == "left-posterior-superior" || space == "lps") return Vec<3>{{1, 1, 1}};
    if (space == "right-anterior-superior" || space == "ras") return Vec<3>{{-1, -1, 1}};
    if (space == "left-anterior-superior" || space == "las") return Vec<3>{{1, -1, 1}};
    return std::nullopt;
}

/// The entries of fields that have one for each axis.
class NrrdFields {
public:
    NrrdFields(const TextHeader& header, std::size_t dimensions, const std::string& path)
        : header_(header) {
        const auto kinds = entriesOf(header.value("kinds"));
        const std::size_t all = entriesOf(header.value("sizes")).size();
        for (std::size_t axis = 0; axis < all; ++axis) {
            const std::string kind = axis < kinds.size() ? lowered(kinds[axis]) : "???";
            for (const char* space : {"domain", "space", "time", "???", "none"})
                if (kind == space) axes_.push_back(axis);
        }
        if (axes_.size() != dimensions)
            throw InputError(
                fmt::format("{}: kinds: {}: {} axes of space, but the image has {}; write it again",
                            path, quotedExcerpt(header.value("kinds")), axes_.size(), dimensions));
    }

    /// The entry of an axis of space; empty where it has none.
    std::string at(std::initializer_list<const char*> keys, std::size_t d) const {
        for (const char* key : keys) {
            const auto entries = entriesOf(header_.value(key));
            if (d < axes_.size() && axes_[d] < entries.size()) return entries[axes_[d]];
        }
        return {};
    }
    double numberAt(std::initializer_list<const char*> keys, std::size_t d) const {
        return numberOf(at(keys, d));
    }

private:
    const TextHeader& header_;
    std::vector<std::size_t> axes_;
};

/// Sets an axis of a header without directions. @return whether its centers had to be guessed
bool setPlainAxis(ImageGrid& grid, const NrrdFields& fields, std::size_t d) {
    const double low = fields.numberAt({"axis mins", "axismins"}, d);
    const double high = fields.numberAt({"axis maxs", "axismaxs"}, d);
    const std::string center = lowered(fields.at({"centers", "centerings"}, d));
    const bool cells = center != "node";
    double spacing = fields.numberAt({"spacings"}, d);
    if (!std::isfinite(spacing))
        spacing = (high - low) / (fields.numberAt({"sizes"}, d) - (cells ? 0 : 1));
    grid.step[d] = {};
    grid.step[d].c[d] = spacing;
    if (!std::isfinite(low)) return false;
    grid.origin.c[d] = low + (cells && std::isfinite(spacing) ? spacing / 2 : 0);
    return center != "cell" && center != "node";
}

}  // namespace

bool namesSides(const TextHeader& header) {
    return turnOf(header.value("space")).has_value();
}

ImageGrid nrrdGrid(const TextHeader& header, std::size_t dimensions, const std::string& path,
                   const Callbacks& callbacks, double& unit) {
    ImageGrid grid;
    const NrrdFields fields(header, dimensions, path);
    const bool directed = header.has("space directions");
    bool guessed = false;
    for (std::size_t d = 0; d < std::min<std::size_t>(3, dimensions); ++d)
        if (directed)
            grid.step[d] = vectorOf(fields.at({"space directions"}, d));
        else
            guessed = setPlainAxis(grid, fields, d) || guessed;
    if (guessed)
        callbacks.warn(path +
                       ": does not say whether axis mins are borders or centers of voxels; they "
                       "are taken as borders, as the format has it");
    const auto origin = entriesOf(header.value("space origin"));
    if (!origin.empty()) grid.origin = vectorOf(origin.front());

    const auto units = entriesOf(header.value("space units"));
    const auto unitAt = [&](std::size_t d) {
        return d < units.size() ? units[d] : fields.at({"units"}, d);
    };
    for (std::size_t d = 1; d < std::min<std::size_t>(3, dimensions); ++d)
        if (unitAt(d) != unitAt(0))
            throw InputError(
                fmt::format("{}: its axes have different units, {} and {}; write it again in mm",
                            path, quotedExcerpt(unitAt(0)), quotedExcerpt(unitAt(d))));
    unit = unitFactor(unitAt(0), path, callbacks);
    if (unit > 0) {
        grid.origin *= unit;
        for (Vec<3>& step : grid.step) step *= unit;
    }
    const auto turn = turnOf(header.value("space"));
    if (!turn)
        callbacks.warn(path +
                       ": does not say in which space of a patient its axes lie: which side "
                       "is left is unknown");
    for (std::size_t row = 0; turn && row < 3; ++row) {
        grid.origin.c[row] *= turn->c[row];
        for (Vec<3>& step : grid.step) step.c[row] *= turn->c[row];
    }
    return grid;
}

}  // namespace vdbpack
