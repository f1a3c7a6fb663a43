#include "vdbpack/formats/grey_values.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace vdbpack {

namespace {

/// Share of spheres smaller than a voxel above which a warning names them.
constexpr double kSmallShare = 0.01;

struct Sample {
    std::string name, file;
};

Sample parsed(const std::string& text) {
    const auto mark = text.find('=');
    if (mark == std::string::npos || mark == 0 || mark + 1 == text.size())
        throw ParameterError("`samples` '" + text + "': write NAME=IMAGE, such as hu=ct.nii.gz");
    return {text.substr(0, mark), text.substr(mark + 1)};
}

/// Slope and intercept of a line, and the column that it is applied to; empty: the only sample.
struct Calibration {
    std::string column;
    double slope = 0, intercept = 0;
};

Calibration parsedCalibration(const GreyRecipe& recipe) {
    const std::string& text = recipe.calibration;
    const auto mark = text.find('=');
    const std::size_t numbers = mark == std::string::npos ? 0 : mark + 1;
    const auto line = parseNumberList(text.substr(numbers));
    if (mark == 0 || !line || line->size() != 2 || (*line)[0] == 0)
        throw ParameterError("`calibration` '" + text +
                             "': write SLOPE,INTERCEPT, which make a grey value a density in "
                             "kg/m³, such as 0.8,5; or COLUMN=SLOPE,INTERCEPT");
    Calibration calibration{mark == std::string::npos ? "" : text.substr(0, mark), (*line)[0],
                            (*line)[1]};
    if (calibration.column.empty()) {
        if (recipe.samples.size() != 1)
            throw ParameterError(fmt::format(
                "`calibration` {}: {}; write NAME={} with the name of {}", text,
                recipe.samples.empty() ? "there are no grey values, as `samples` is not set"
                                       : "there are several `samples`",
                text, recipe.samples.empty() ? "a column of the pack" : "one of them"));
        calibration.column = parsed(recipe.samples.front()).name;
    }
    return calibration;
}

/// A and B of a modulus.
std::pair<double, double> parsedModulus(const std::string& text) {
    const auto numbers = parseNumberList(text);
    if (!numbers || numbers->empty() || numbers->size() > 2 || !((*numbers)[0] > 0) ||
        !(numbers->back() >= 0))
        throw ParameterError("`modulus` '" + text +
                             "': write A,B of Young's modulus A * density^B in MPa, the density in "
                             "g/cm³ and B not negative, such as 6850,1.49; or the modulus itself");
    return {(*numbers)[0], numbers->size() == 2 ? (*numbers)[1] : 0};
}

std::vector<std::string> checkSamples(const std::vector<std::string>& samples) {
    std::set<std::string> names{
        "id",         "x",           "y",        "z",         "radius",
        "r",          "pscale",      "diameter", kPartColumn, kDensityColumn,
        kClassColumn, kModulusColumn};
    std::vector<std::string> files;
    PackAttributes known;
    forEachAttribute(known, [&](std::string_view name, const auto&) { names.emplace(name); });
    for (const std::string& text : samples) {
        const Sample sample = parsed(text);
        if (!names.insert(sample.name).second)
            throw ParameterError("`samples` '" + text + "': there is a column '" + sample.name +
                                 "' already; give another name");
        requireGreyImage("`samples` '" + text + "'", sample.file);
        files.push_back(sample.file);
    }
    return files;
}

void dropColumn(PackAttributes& pack, const char* name) {
    pack.columns.erase(std::remove_if(pack.columns.begin(), pack.columns.end(),
                                      [&](const Column& c) { return c.name == name; }),
                       pack.columns.end());
}

/// Replaces the column of this name, or adds it.
void setColumn(PackAttributes& pack, const char* name, std::vector<double> numbers) {
    dropColumn(pack, name);
    pack.columns.push_back({name, std::move(numbers), {}});
}

/// Warns of spheres that are smaller than the voxels they are sampled from.
void warnOfSmall(const std::vector<Sphere<3>>& balls, const Image& image, const std::string& file,
                 const Callbacks& callbacks) {
    double across = 0;  // a voxel's shortest edge
    for (const Vec<3>& step : image.grid.step)
        across = across > 0 ? std::min(across, length(step)) : length(step);
    const auto small = std::count_if(balls.begin(), balls.end(), [&](const Sphere<3>& ball) {
        return 2 * ball.radius < across;
    });
    if (static_cast<double>(small) > kSmallShare * static_cast<double>(balls.size()))
        callbacks.warn(fmt::format(
            "{}: {} of {} spheres are smaller than its voxels of {:.3g} mm, and have the value, "
            "and "
            "the noise, of single voxels; `sampleLength` averages over more, such as {:.2g} mm",
            file, small, balls.size(), across, 3 * across));
}

/// Warns of a length in another unit: less than all spheres, or much of the pack.
void warnOfLength(double length, const std::vector<Sphere<3>>& spheres,
                  const Callbacks& callbacks) {
    if (!(length > 0)) return;
    double smallest = std::numeric_limits<double>::infinity();
    Box<3> box;
    for (const Sphere<3>& s : spheres) smallest = std::min(smallest, s.radius), box.add(s.center);
    const Vec<3> size = box.size();
    const double across = std::max({size[0], size[1], size[2]});
    if (length <= 2 * smallest)
        callbacks.warn(
            fmt::format("`sampleLength` {:g} mm has no effect: every sphere is larger "
                        "(smallest diameter {:.3g} mm)",
                        length, 2 * smallest));
    else if (length > across / 2)
        callbacks.warn(
            fmt::format("`sampleLength` {:g} mm takes means over much of the pack, which "
                        "is {:.3g} mm long; check its unit",
                        length, across));
}

/// Warns of an image with a few whole values, as a label map has and a scan has not.
void warnOfLabels(const Image& image, const std::string& file, const Callbacks& callbacks) {
    constexpr std::size_t kFewest = 3, kMost = 64, kRead = 1 << 20;
    std::set<double> found;
    image.visit([&](const auto* numbers) {
        const std::size_t step = 1 + image.values() / kRead;
        for (std::size_t i = 0; i < image.values() && found.size() <= kMost; i += step) {
            const double value = image.value(numbers[i]);
            found.insert(value);
            if (value != std::floor(value)) return found.clear();
        }
    });
    if (found.size() >= kFewest && found.size() <= kMost)
        callbacks.warn(
            fmt::format("`samples`: {} has {} different values, all whole, from {:g} to {:g}, as a "
                        "label map has; name the scan itself",
                        file, found.size(), *found.begin(), *found.rbegin()));
}

template <int Dim>
void addSamples(const GreyRecipe& recipe, const DomainRecipe& domain, Pack<Dim>& pack,
                const Callbacks& callbacks) {
    const std::vector<std::string>& samples = recipe.samples;
    if (samples.empty() || pack.spheres.empty()) return;
    std::vector<Sphere<3>> balls;
    for (const Sphere<Dim>& s : pack.spheres) {
        Sphere<3> ball;
        for (int d = 0; d < 3; ++d) ball.center[d] = d < Dim ? s.center[d] : pack.sliceHeight;
        ball.radius = s.radius;
        balls.push_back(ball);
    }
    warnOfLength(recipe.sampleLength, balls, callbacks);
    for (auto& ball : balls) ball.radius = std::max(ball.radius, recipe.sampleLength / 2);
    for (const std::string& text : samples) {
        const Sample sample = parsed(text);
        const Image image = readGreyImage(sample.file, domain, callbacks);
        warnOfSmall(balls, image, sample.file, callbacks);
        warnOfLabels(image, sample.file, callbacks);
        auto means = ballMeans(image, balls);
        const auto outside =
            std::count_if(means.begin(), means.end(), [](double v) { return std::isnan(v); });
        if (static_cast<std::size_t>(outside) == means.size())
            throw InputError(sample.file +
                             ": lies elsewhere than all spheres; check that it is of the same "
                             "scan, `space`, and the unit of the domain or pack");
        if (outside > 0)
            callbacks.warn(
                fmt::format("{}: {} of {} {} lie outside of this image, and have the value nan, "
                            "which spheres of an implant may have; else check `space` and that "
                            "the image is of the same scan",
                            sample.file, outside, means.size(), Measure<Dim>::kSpheres));
        setColumn(pack, sample.name.c_str(), std::move(means));
    }
}

constexpr int kMostClasses = 1'000'000;
/// The least density that a calibration gives, kg/m³: about that of air.
constexpr double kLeastDensity = 1;
/// More than any bone, tooth or ceramic has, kg/m³.
constexpr double kMostDensity = 6000;

/// Bone whose densities differ by no more than this share of them is none.
constexpr double kLeastRange = 0.02;

/// Densities of all spheres, and which are those of their part alone.
struct Densities {
    std::vector<double> all;
    std::vector<std::uint8_t> own;
};

/// Warns where grey values differ, and densities hardly do.
void warnOfSlope(const std::string& calibration, const std::vector<double>& grey,
                 const Densities& densities, const Callbacks& callbacks) {
    double low = std::numeric_limits<double>::infinity(), high = -low, dark = low, light = -low;
    for (std::size_t i = 0; i < grey.size(); ++i) {
        if (densities.own[i] || !std::isfinite(grey[i])) continue;
        low = std::min(low, densities.all[i]);
        high = std::max(high, densities.all[i]);
        dark = std::min(dark, grey[i]);
        light = std::max(light, grey[i]);
    }
    if (light > dark && high > kLeastDensity && high - low < kLeastRange * high)
        callbacks.warn(fmt::format(
            "`calibration` {}: the grey values of spheres go from {:.4g} to {:.4g}, but their "
            "densities only from {:.5g} to {:.5g} kg/m³. Check the slope, in kg/m³ by grey value",
            calibration, dark, light, low, high));
}

/// Densities by the line of a calibration.
Densities densitiesOf(const GreyRecipe& recipe, const PartProperties& parts,
                      const PackAttributes& pack, const Callbacks& callbacks) {
    const Calibration line = parsedCalibration(recipe);
    const Column* grey = columnOfNumbers(pack, line.column.c_str());
    if (!grey)
        throw ParameterError(fmt::format("`calibration` {}: the pack has no column {} of numbers",
                                         recipe.calibration, quotedExcerpt(line.column)));
    const Materials materials(pack);
    Densities densities{grey->numbers, std::vector<std::uint8_t>(grey->numbers.size())};
    std::size_t unknown = 0, low = 0, high = 0;
    for (std::size_t i = 0; i < densities.all.size(); ++i) {
        double& density = densities.all[i];
        if (const auto own = parts.density.find(materials.withoutClass(i));
            own != parts.density.end()) {
            density = own->second;
            densities.own[i] = 1;
            continue;
        }
        if (!std::isfinite(density)) {
            ++unknown;
            density = kDefaultDensity;
            continue;
        }
        density = line.slope * density + line.intercept;
        high += density > kMostDensity;
        if (density >= kLeastDensity) continue;
        ++low;
        density = kLeastDensity;
    }
    if (unknown > 0)
        callbacks.warn(
            fmt::format("{} of {} spheres have no grey value; their density is {:g} kg/m³", unknown,
                        densities.all.size(), kDefaultDensity));
    if (low > 0)
        callbacks.warn(fmt::format(
            "`calibration` {} gives {} of {} spheres less than {:g} kg/m³, which they have now. "
            "Check {}",
            recipe.calibration, low, densities.all.size(), kLeastDensity,
            2 * low > densities.all.size()
                ? "that slope and intercept give kg/m³, which is mg/cm³, and not g/cm³"
                : "slope and intercept, or whether fat and air belong to the domain"));
    if (high > 0)
        callbacks.warn(fmt::format(
            "`calibration` {} gives {} of {} spheres more than {:g} kg/m³, which no bone has. "
            "Check that slope and intercept stand in this order and give kg/m³, which is mg/cm³, "
            "and not g/m³",
            recipe.calibration, high, densities.all.size(), kMostDensity));
    warnOfSlope(recipe.calibration, grey->numbers, densities, callbacks);
    return densities;
}

/// Of equal width, from the least to the greatest density from grey values; 0 for others.
std::vector<double> classesOf(const Densities& densities, int count) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < densities.all.size(); ++i) {
        if (densities.own[i]) continue;
        low = std::min(low, densities.all[i]);
        high = std::max(high, densities.all[i]);
    }
    const double width = (high - low) / count;
    std::vector<double> classes(densities.all.size());
    if (!(width > 0)) return classes;
    for (std::size_t i = 0; i < classes.size(); ++i)
        if (!densities.own[i])
            classes[i] = std::min(std::floor((densities.all[i] - low) / width), count - 1.0);
    return classes;
}

/// @param densities  kg/m³; empty: no modulus follows from them.
std::vector<double> moduliOf(const GreyRecipe& recipe, const PartProperties& parts,
                             const PackAttributes& pack, std::size_t count,
                             const std::vector<double>& densities) {
    using Law = std::pair<double, double>;
    const Law common = recipe.modulus.empty() ? Law() : parsedModulus(recipe.modulus);
    std::map<std::int32_t, Law> laws;
    for (const auto& [part, text] : parts.modulus) laws[part] = parsedModulus(text);
    const Materials materials(pack);
    std::vector<double> moduli;
    moduli.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto own = laws.find(materials.partOf(i));
        const auto& [first, power] = own == laws.end() ? common : own->second;
        moduli.push_back(power == 0 ? first : first * std::pow(densities[i] / 1000, power));
    }
    return moduli;
}

}  // namespace

std::vector<std::string> columnsOfNumbers(const PackAttributes& pack) {
    std::vector<std::string> names;
    for (const Column& column : pack.columns)
        if (!column.numbers.empty()) names.push_back(column.name);
    return names;
}

std::vector<std::string> checkGrey(const GreyRecipe& recipe, const std::string& density,
                                   const std::vector<std::string>* columns) {
    if (recipe.classes < 1 || recipe.classes > kMostClasses)
        throw ParameterError(fmt::format("`grey.classes` {}: from 1 to {} classes of density",
                                         recipe.classes, kMostClasses));
    auto files = checkSamples(recipe.samples);
    if (!recipe.calibration.empty()) {
        const std::string column = parsedCalibration(recipe).column;
        const bool sampled =
            std::any_of(recipe.samples.begin(), recipe.samples.end(),
                        [&](const std::string& text) { return parsed(text).name == column; });
        if (columns && !sampled &&
            std::find(columns->begin(), columns->end(), column) == columns->end())
            throw ParameterError(
                fmt::format("`calibration` {}: there is no column {} of numbers; the spheres have "
                            "{}{}, and add those of `samples`",
                            recipe.calibration, quotedExcerpt(column), fmt::join(*columns, ", "),
                            columns->empty() ? "none" : ""));
        if (!density.empty())
            throw ParameterError(
                "`density` and `calibration`: spheres have one density; leave one of them out");
    }
    if (!recipe.modulus.empty() && needsDensity(recipe.modulus) && recipe.calibration.empty())
        throw ParameterError("`modulus` " + recipe.modulus +
                             ": follows from densities; set `calibration`, or one modulus alone");
    return files;
}

bool needsDensity(const std::string& modulus) {
    return parsedModulus(modulus).second != 0;
}

template <int Dim>
void addGreyValues(const GreyRecipe& recipe, const DomainRecipe& domain,
                   const PartProperties& parts, Pack<Dim>& pack, const Callbacks& callbacks) {
    if ((recipe.empty() && parts.modulus.empty()) || pack.spheres.empty()) return;
    addSamples(recipe, domain, pack, callbacks);
    std::vector<double> densities;
    if (!recipe.calibration.empty()) {
        Densities found = densitiesOf(recipe, parts, pack, callbacks);
        // What another calibration said is no longer true.
        dropColumn(pack, kModulusColumn);
        setColumn(pack, kDensityColumn, found.all);
        setColumn(pack, kClassColumn, classesOf(found, recipe.classes));
        densities = std::move(found.all);
    }
    if (!recipe.modulus.empty() || !parts.modulus.empty())
        setColumn(pack, kModulusColumn,
                  moduliOf(recipe, parts, pack, pack.spheres.size(), densities));
}

void keepDensities(PackAttributes& pack, std::size_t spheres, double all,
                   const std::map<std::int32_t, double>& ofMaterials) {
    if (spheres == 0 || (!(all > 0) && ofMaterials.empty())) return;
    const SphereDensities densities(pack, all, ofMaterials);
    std::vector<double> each(spheres);
    for (std::size_t i = 0; i < spheres; ++i) each[i] = densities.of(i);
    setColumn(pack, kDensityColumn, std::move(each));
}

template void addGreyValues(const GreyRecipe&, const DomainRecipe&, const PartProperties&, Pack<2>&,
                            const Callbacks&);
template void addGreyValues(const GreyRecipe&, const DomainRecipe&, const PartProperties&, Pack<3>&,
                            const Callbacks&);

}  // namespace vdbpack
