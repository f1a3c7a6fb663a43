// What spheres are made of, for programs that know materials by number.
#pragma once

#include "vdbpack/core/pack.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// The column of a pack of several parts: which one a sphere fills, counted from 0.
inline constexpr const char* kPartColumn = "part";
/// Columns of densities from grey values, of the classes that they fall into, counted from 0, and
/// of Young's moduli.
inline constexpr const char* kDensityColumn = "density_kg_m3";
inline constexpr const char* kClassColumn = "density_class";
inline constexpr const char* kModulusColumn = "modulus_MPa";

/// The column of this name, if it holds numbers; else null.
const Column* columnOfNumbers(const PackAttributes& pack, const char* name);

/// The names of the parts of a pack by their numbers; empty: it has none.
const std::vector<std::string>& partNames(const PackAttributes& pack);
/// Gives them to its parts, if it has any.
void setPartNames(PackAttributes& pack, std::vector<std::string> names);

/// What a file says that its numbers of materials are (`Materials::formula`), and how parts and
/// regions follow from them.
struct MaterialNumbers {
    std::string formula;
    std::int32_t regions = 0;  ///< of each part, "2 part + region"; 0: parts have none

    MaterialNumbers() = default;
    /// @param text  of a comment. @param word  after which the formula stands there
    MaterialNumbers(std::string_view text, std::string_view word);
    /// Whether they are a count of what occurs, from which nothing follows.
    bool areCounted() const { return formula.compare(0, 9, "number of") == 0; }
    /// Splits the numbers in the column `region` of a pack into parts and regions.
    void split(PackAttributes& pack) const;
};

/// Materials of a pack, counted from 0: its regions, or its parts; where parts have several
/// regions, the regions of each part one after another (part 1, region 0 of two: 2). Where spheres
/// have classes of density, the combinations of part, region and class that occur, in that order.
///
/// Parts and classes are the columns of these names, if they have whole numbers from 0 and the pack
/// has no column `type`, which says more.
class Materials {
public:
    /// What a material is; parts, regions and classes that a pack does not have are 0.
    struct Kind {
        std::int32_t part, region, densityClass;
    };

    /// @throws ParameterError for regions that are negative, or too many materials.
    explicit Materials(const PackAttributes& pack);

    /// Whether the pack says anything of them.
    bool any() const { return regions_ > 0 || parts_ || classes_; }
    bool hasParts() const { return parts_ != nullptr; }
    std::int32_t partOf(std::size_t i) const {
        return parts_ ? static_cast<std::int32_t>((*parts_)[i]) : 0;
    }
    std::int32_t of(std::size_t i) const {
        const std::int32_t plain = withoutClass(i);
        return classes_ ? rank_[keyOf(plain, (*classes_)[i])] : plain;
    }
    /// The material where classes of density do not count: by part and region.
    std::int32_t withoutClass(std::size_t i) const {
        return withoutClass(partOf(i), regions_ > 0 ? pack_.region[i] : 0);
    }
    std::int32_t withoutClass(std::int32_t part, std::int32_t region) const {
        return regions_ > 0 ? part * regions_ + region : part;
    }
    /// @param material  one that `of` returns.
    Kind kindOf(std::int32_t material) const;
    /// Such as "region", "part" or "2 part + region".
    std::string formula() const;

private:
    std::size_t keyOf(std::int32_t plain, double densityClass) const {
        return static_cast<std::size_t>(plain) * classCount_ +
               static_cast<std::size_t>(densityClass);
    }

    const PackAttributes& pack_;
    std::int32_t regions_ = 0;                      // the largest + 1; 0: there are none
    const std::vector<double>* parts_ = nullptr;    // null: there are none
    const std::vector<double>* classes_ = nullptr;  // null: there are none
    std::size_t classCount_ = 0;
    std::vector<std::int32_t> rank_;  // by key, where there are classes
};

/// Densities of the spheres of a pack, kg/m³: by material, else one for all, else of the
/// column `kDensityColumn` (0 for spheres that were added to those of a file), else
/// `kDefaultDensity`.
class SphereDensities {
public:
    /// @param all          0: none is requested.
    /// @param ofMaterials  by `Materials::withoutClass`; may be empty.
    SphereDensities(const PackAttributes& pack, double all,
                    std::map<std::int32_t, double> ofMaterials);

    double of(std::size_t i) const;
    /// What is requested for a part and region, or else for all.
    double of(const Materials::Kind& kind) const;
    /// The column `density` of a file, in a unit that nobody knows; null where densities were
    /// requested or there is none.
    const Column* unconverted() const { return unconverted_; }

private:
    double requested(std::int32_t material) const;

    Materials materials_;
    double all_;
    std::map<std::int32_t, double> ofMaterials_;
    const Column* column_ = nullptr;
    const Column* unconverted_ = nullptr;
};

}  // namespace vdbpack
