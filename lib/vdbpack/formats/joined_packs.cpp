#include "vdbpack/formats/joined_packs.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

/// Name of the column that marks spheres that stood already.
const char* const kExisting = "existing";

/// The largest of some numbers.
/// @throws InputError where `more` others above it would not fit into 64 bits.
std::int64_t lastBefore(const std::vector<std::int64_t>& numbers, std::size_t more,
                        const char* what) {
    const std::int64_t last = *std::max_element(numbers.begin(), numbers.end());
    if (last > std::numeric_limits<std::int64_t>::max() - static_cast<std::int64_t>(more))
        throw InputError(
            fmt::format("the largest {}, {}, leaves no values for the spheres that are added; "
                        "renumber the spheres",
                        what, last));
    return last;
}

}  // namespace

template <int Dim>
void requireRoomToNumber(const Pack<Dim>& pack, const std::string& file) {
    constexpr std::size_t kMostAdded = std::size_t{1} << 32;
    try {
        if (!pack.id.empty()) lastBefore(pack.id, kMostAdded, "id");
        if (!pack.order.empty()) lastBefore(pack.order, kMostAdded, "order");
    } catch (const InputError& e) {
        throw InputError(file + ": " + e.what());
    }
}

namespace {

/// Removes columns in which the 0 of added spheres would mean something: classes and moduli.
void dropClasses(PackAttributes& pack) {
    auto& columns = pack.columns;
    columns.erase(std::remove_if(columns.begin(), columns.end(),
                                 [](const Column& c) {
                                     return c.name == kClassColumn || c.name == kModulusColumn;
                                 }),
                  columns.end());
}

}  // namespace

template <int Dim>
Pack<Dim> appended(Pack<Dim> base, const std::vector<Sphere<Dim>>& added) {
    if (!added.empty()) dropClasses(base);
    const std::size_t before = base.spheres.size(), more = added.size();
    const std::size_t all = before + more;
    base.depth.clear();
    base.contacts.clear();
    const auto numberOn = [more](std::vector<std::int64_t>& numbers, const char* what) {
        if (numbers.empty()) return;
        std::int64_t next = lastBefore(numbers, more, what);
        for (std::size_t i = 0; i < more; ++i) numbers.push_back(++next);
    };
    numberOn(base.id, "id");
    numberOn(base.order, "order");
    forEachAttribute(base, [all](std::string_view, auto& values) {
        if (!values.empty()) values.resize(all);
    });
    base.spheres.insert(base.spheres.end(), added.begin(), added.end());
    return base;
}

template <int Dim>
Pack<Dim> joined(Pack<Dim> base, const Pack<Dim>& added) {
    const std::size_t before = base.spheres.size();
    if (base.order.empty())
        for (std::size_t i = 0; i < before; ++i) base.order.push_back(static_cast<std::int64_t>(i));
    base.region.resize(before, 0);
    auto& columns = base.columns;
    columns.erase(std::remove_if(columns.begin(), columns.end(),
                                 [](const Column& c) { return c.name == kExisting; }),
                  columns.end());
    Column mark;
    mark.name = kExisting;
    mark.numbers.assign(before, 1.0);
    columns.push_back(std::move(mark));
    base = appended(std::move(base), added.spheres);
    if (before == 0) {
        base.order = added.order;  // nothing to continue from
    } else if (!added.order.empty()) {
        // In the order of the front, of which a rank has a part.
        for (auto* numbers : {&base.id, &base.order}) {
            if (numbers->empty()) continue;
            const std::int64_t first = (*numbers)[before];
            for (std::size_t i = 0; i < added.order.size(); ++i)
                (*numbers)[before + i] = first + added.order[i];
        }
    }
    base.region.resize(base.spheres.size(), 0);
    columns.back().numbers.resize(base.spheres.size(), 0.0);
    base.sliceHeight = added.sliceHeight;
    return base;
}

void appendPart(Pack<3>& all, Pack<3> part, std::int32_t number) {
    if (all.columns.empty()) all.columns.push_back({kPartColumn, {}, {}});
    const std::size_t before = all.spheres.size(), count = part.spheres.size();
    const auto add = [&](auto& values, auto& more) {
        if (more.empty() && values.empty()) return;
        values.resize(before);
        more.resize(count);
        values.insert(values.end(), more.begin(), more.end());
    };
    add(all.region, part.region);
    add(all.depth, part.depth);
    for (std::int64_t& order : part.order) order += static_cast<std::int64_t>(before);
    add(all.order, part.order);
    all.columns.front().numbers.insert(all.columns.front().numbers.end(), count, number);
    all.spheres.insert(all.spheres.end(), part.spheres.begin(), part.spheres.end());
}

template void requireRoomToNumber(const Pack<2>&, const std::string&);
template void requireRoomToNumber(const Pack<3>&, const std::string&);
template Pack<2> appended(Pack<2>, const std::vector<Sphere<2>>&);
template Pack<3> appended(Pack<3>, const std::vector<Sphere<3>>&);
template Pack<2> joined(Pack<2>, const Pack<2>&);
template Pack<3> joined(Pack<3>, const Pack<3>&);

}  // namespace vdbpack
