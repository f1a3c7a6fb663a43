#include "vdbpack/run/sample_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/image_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <system_error>

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

}  // namespace

std::vector<std::string> checkSamples(const std::vector<std::string>& samples) {
    std::set<std::string> names{"id", "x", "y", "z", "radius", "r", "pscale", "diameter", "part"};
    std::vector<std::string> files;
    PackAttributes known;
    forEachAttribute(known, [&](std::string_view name, const auto&) { names.emplace(name); });
    for (const std::string& text : samples) {
        const Sample sample = parsed(text);
        if (!names.insert(sample.name).second)
            throw ParameterError("`samples` '" + text + "': there is a column '" + sample.name +
                                 "' already; give another name");
        if (!namesImage(sample.file))
            throw ParameterError("`samples` '" + text + "': " + sample.file +
                                 " is no image by its name");
        std::error_code ignored;
        if (sample.file.find('*') == std::string::npos &&
            !std::filesystem::exists(sample.file, ignored))
            throw IoError(sample.file + ": there is no such file");
        files.push_back(sample.file);
    }
    return files;
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
        DomainRecipe recipe;
        recipe.source = sample.file;
        recipe.space = domain.space;
        const Image image = readDomainImage(recipe, callbacks);
        if (image.layers != 1)
            throw InputError(sample.file +
                             ": has several values at each voxel, of which there is "
                             "no mean; give one layer");
        auto means = ballMeans(image, balls);
        const auto outside =
            std::count_if(means.begin(), means.end(), [](double v) { return std::isnan(v); });
        if (outside > 0)
            callbacks.warn(fmt::format(
                "{}: {} of {} {} lie outside of this image, and have the value nan. Check that it "
                "has the same axes as the domain",
                sample.file, outside, means.size(), Measure<Dim>::kSpheres));
        pack.columns.erase(std::remove_if(pack.columns.begin(), pack.columns.end(),
                                          [&](const Column& c) { return c.name == sample.name; }),
                           pack.columns.end());
        pack.columns.push_back({sample.name, std::move(means), {}});
    }
}

template void addSamples(const std::vector<std::string>&, const DomainRecipe&, Pack<2>&,
                         const Callbacks&);
template void addSamples(const std::vector<std::string>&, const DomainRecipe&, Pack<3>&,
                         const Callbacks&);

}  // namespace vdbpack
