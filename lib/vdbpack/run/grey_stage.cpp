#include "vdbpack/run/grey_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/image_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbpack {

namespace {

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
    if (!numbers || numbers->size() != 2 || !((*numbers)[0] > 0))
        throw ParameterError("`modulus` '" + text +
                             "': write A,B of Young's modulus A * density^B in MPa, the density in "
                             "g/cm³, such as 6850,1.49");
    return {(*numbers)[0], (*numbers)[1]};
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

/// Replaces the column of this name, or adds it.
void setColumn(PackAttributes& pack, const char* name, std::vector<double> numbers) {
    pack.columns.erase(std::remove_if(pack.columns.begin(), pack.columns.end(),
                                      [&](const Column& c) { return c.name == name; }),
                       pack.columns.end());
    pack.columns.push_back({name, std::move(numbers), {}});
}

template <int Dim>
void addSamples(const std::vector<std::string>& samples, const DomainRecipe& domain,
                Pack<Dim>& pack, const Callbacks& callbacks) {
    if (samples.empty() || pack.spheres.empty()) return;
    std::vector<Sphere<3>> balls;
    for (const Sphere<Dim>& s : pack.spheres) {
        Sphere<3> ball;
        for (int d = 0; d < 3; ++d) ball.center[d] = d < Dim ? s.center[d] : pack.sliceHeight;
        ball.radius = s.radius;
        balls.push_back(ball);
    }
    for (const std::string& text : samples) {
        const Sample sample = parsed(text);
        const Image image = readGreyImage(sample.file, domain, callbacks);
        auto means = ballMeans(image, balls);
        const auto outside =
            std::count_if(means.begin(), means.end(), [](double v) { return std::isnan(v); });
        if (outside > 0)
            callbacks.warn(fmt::format(
                "{}: {} of {} {} lie outside of this image, and have the value nan. Check that it "
                "has the same axes as the domain",
                sample.file, outside, means.size(), Measure<Dim>::kSpheres));
        setColumn(pack, sample.name.c_str(), std::move(means));
    }
}

/// The least density that a calibration gives, kg/m³: about that of air.
constexpr double kLeastDensity = 1;

/// Densities of all spheres by the line of a calibration.
std::vector<double> densitiesOf(const GreyRecipe& recipe,
                                const std::map<std::int32_t, double>& densities,
                                const PackAttributes& pack, const Callbacks& callbacks) {
    const Calibration line = parsedCalibration(recipe);
    const Column* grey = columnOfNumbers(pack, line.column.c_str());
    if (!grey)
        throw ParameterError(fmt::format("`calibration` {}: the pack has no column {} of numbers",
                                         recipe.calibration, quotedExcerpt(line.column)));
    const Materials materials(pack);
    std::vector<double> all = grey->numbers;
    std::size_t unknown = 0, low = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!densities.empty())
            if (const auto own = densities.find(materials.of(i)); own != densities.end()) {
                all[i] = own->second;
                continue;
            }
        if (!std::isfinite(all[i])) {
            ++unknown;
            all[i] = kDefaultDensity;
            continue;
        }
        all[i] = line.slope * all[i] + line.intercept;
        if (all[i] >= kLeastDensity) continue;
        ++low;
        all[i] = kLeastDensity;
    }
    if (unknown > 0)
        callbacks.warn(
            fmt::format("{} of {} spheres have no grey value; their density is {:g} "
                        "kg/m³",
                        unknown, all.size(), kDefaultDensity));
    if (low > 0)
        callbacks.warn(fmt::format(
            "`calibration` {} gives {} of {} spheres less than {:g} kg/m³, which they have now. "
            "Check slope and intercept, or whether fat and air belong to the domain",
            recipe.calibration, low, all.size(), kLeastDensity));
    return all;
}

/// Of equal width, from the least to the greatest density.
std::vector<double> classesOf(const std::vector<double>& densities, int count) {
    const auto [least, most] = std::minmax_element(densities.begin(), densities.end());
    const double low = *least, width = (*most - *least) / count;
    std::vector<double> classes;
    classes.reserve(densities.size());
    for (const double d : densities)
        classes.push_back(width > 0 ? std::min(std::floor((d - low) / width), count - 1.0) : 0);
    return classes;
}

std::vector<double> moduliOf(const std::string& modulus, const std::vector<double>& densities) {
    const auto [a, b] = parsedModulus(modulus);
    std::vector<double> moduli;
    moduli.reserve(densities.size());
    for (const double d : densities) moduli.push_back(a * std::pow(d / 1000, b));
    return moduli;
}

}  // namespace

std::vector<std::string> checkGrey(const RunSettings& settings) {
    const GreyRecipe& recipe = settings.grey;
    if (settings.ranks && !recipe.empty())
        throw ParameterError(
            "`samples`: are not taken over several processes; take them from a file");
    auto files = checkSamples(recipe.samples);
    if (!recipe.calibration.empty()) {
        parsedCalibration(recipe);
        if (!settings.density.empty())
            throw ParameterError(
                "`density` and `calibration`: spheres have one density; leave "
                "one of them out");
    }
    if (!recipe.modulus.empty()) {
        parsedModulus(recipe.modulus);
        if (recipe.calibration.empty())
            throw ParameterError("`modulus` " + recipe.modulus +
                                 ": follows from densities; set `calibration`");
    }
    return files;
}

template <int Dim>
void addGreyValues(const GreyRecipe& recipe, const DomainRecipe& domain,
                   const std::map<std::int32_t, double>& densities, Pack<Dim>& pack,
                   const Callbacks& callbacks) {
    if (recipe.empty() || pack.spheres.empty()) return;
    addSamples(recipe.samples, domain, pack, callbacks);
    if (recipe.calibration.empty()) return;
    const auto all = densitiesOf(recipe, densities, pack, callbacks);
    setColumn(pack, kDensityColumn, all);
    if (!recipe.modulus.empty()) setColumn(pack, kModulusColumn, moduliOf(recipe.modulus, all));
    setColumn(pack, kClassColumn, classesOf(all, recipe.classes));
}

template void addGreyValues(const GreyRecipe&, const DomainRecipe&,
                            const std::map<std::int32_t, double>&, Pack<2>&, const Callbacks&);
template void addGreyValues(const GreyRecipe&, const DomainRecipe&,
                            const std::map<std::int32_t, double>&, Pack<3>&, const Callbacks&);

}  // namespace vdbpack
