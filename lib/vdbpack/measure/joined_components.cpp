#include "vdbpack/measure/joined_components.h"

#include "vdbpack/core/disjoint_sets.h"

#include <algorithm>
#include <tuple>
#include <unordered_map>

namespace vdbpack {

void JoinedComponents::add(std::size_t own, const std::vector<std::uint32_t>& component,
                           const std::vector<std::int64_t>& rows,
                           const std::vector<std::uint8_t>& shared) {
    std::vector<std::uint32_t> size(component.size());
    std::vector<std::uint8_t> reaches(component.size());
    for (std::size_t i = 0; i < own; ++i) ++size[component[i]];
    const std::uint64_t part = (parts_++ * static_cast<std::uint64_t>(ranks_.count()) +
                                static_cast<std::uint64_t>(ranks_.rank()))
                               << 32;
    for (std::size_t i = 0; i < component.size(); ++i) {
        // Those without own spheres are the matter of other parts.
        if (!shared[i] || size[component[i]] == 0) continue;
        known_.push_back({part | component[i], static_cast<std::uint64_t>(rows[i])});
        reaches[component[i]] = 1;
    }
    for (std::size_t c = 0; c < size.size(); ++c) {
        if (size[c] == 0) continue;
        if (reaches[c]) {
            sizes_.push_back({part | c, size[c]});
        } else {
            ++alone_.components;
            alone_.largest = std::max<std::uint64_t>(alone_.largest, size[c]);
        }
    }
}

/// The pairs of labels that name one component, as far as this rank finds them.
std::vector<JoinedComponents::Entry> JoinedComponents::links() {
    // What several parts know of a sphere meets at one rank.
    const auto each = static_cast<std::size_t>(ranks_.count());
    std::vector<std::vector<Entry>> byRow(each);
    for (const Entry& k : known_) byRow[k.number % each].push_back(k);
    known_ = {};
    std::vector<Entry> here = joined(exchanged(ranks_, std::move(byRow)));
    std::sort(here.begin(), here.end(), [](const Entry& a, const Entry& b) {
        return std::tie(a.number, a.label) < std::tie(b.number, b.label);
    });
    std::vector<Entry> links;  // from one label to another
    for (std::size_t i = 1; i < here.size(); ++i)
        if (here[i].number == here[i - 1].number && here[i].label != here[i - 1].label)
            links.push_back({here[i - 1].label, here[i].label});
    std::sort(links.begin(), links.end(), [](const Entry& a, const Entry& b) {
        return std::tie(a.label, a.number) < std::tie(b.label, b.number);
    });
    links.erase(std::unique(links.begin(), links.end(),
                            [](const Entry& a, const Entry& b) {
                                return a.label == b.label && a.number == b.number;
                            }),
                links.end());
    return links;
}

JoinedComponents::Result JoinedComponents::join() {
    std::unordered_map<std::uint64_t, std::uint32_t> numberOf;  // of a component that was linked
    const std::vector<Entry> all = joined(gathered(&ranks_, links()));
    for (const Entry& link : all)
        for (const std::uint64_t label : {link.label, link.number})
            numberOf.emplace(label, static_cast<std::uint32_t>(numberOf.size()));
    DisjointSets sets(numberOf.size());
    for (const Entry& link : all) sets.join(numberOf[link.label], numberOf[link.number]);
    std::vector<std::uint64_t> spheres(numberOf.size());
    for (const Entry& c : sizes_) {
        const auto found = numberOf.find(c.label);
        if (found != numberOf.end()) {
            spheres[sets.find(found->second)] += c.number;
        } else {
            ++alone_.components;
            alone_.largest = std::max(alone_.largest, c.number);
        }
    }
    ranks_.sum(spheres);
    Result result;
    result.components = sumOver(&ranks_, alone_.components);
    for (const auto& largest : gathered(&ranks_, std::vector<std::uint64_t>{alone_.largest}))
        result.largest = std::max(result.largest, largest.front());
    for (const std::uint64_t n : spheres) {
        result.components += n > 0;
        result.largest = std::max(result.largest, n);
    }
    return result;
}

}  // namespace vdbpack
