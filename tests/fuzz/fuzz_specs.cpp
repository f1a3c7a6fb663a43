// Texts of the command line: an input is a line KIND TEXT and, for radii by table, the table below.
#include "fuzz_file.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/voids/orientation.h"

#include <algorithm>
#include <string_view>

using namespace vdbpack;

namespace {

void requireSizes(const SizeDistribution& sizes) {
    for (const double u : {0.0, 0.3, 1.0}) {
        const double r = sizes.quantile(u);
        // Drawn radii are floats.
        if (!(r >= sizes.min() * (1 - 1e-6)) || !(r <= sizes.max() * (1 + 1e-6)))
            fuzz::report("a radius out of range");
    }
}

bool startsWith(const std::string& text, std::string_view start) {
    return text.compare(0, start.size(), start) == 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile file("t.csv");
    const std::string input(reinterpret_cast<const char*>(data), size);
    const std::string line = input.substr(0, input.find('\n'));
    const std::string kind = line.substr(0, line.find(' '));
    const std::string text = line.size() > kind.size() ? line.substr(kind.size() + 1) : "";
    try {
        if (kind == "table" || kind == "psd") {
            const std::string& path = file.write(input.substr(std::min(line.size() + 1, size)));
            const int dim = text == "2" ? 2 : 3;
            requireSizes(SizeDistribution::parse(kind + ":" + path, dim));
        } else if (kind == "radius" && !startsWith(text, "table:") && !startsWith(text, "psd:")) {
            requireSizes(SizeDistribution::parse(text, 3));
        } else if (kind == "angle") {
            const auto angle = AngleDistribution::parse(text);
            for (const double u : {0.0, 0.3, 1.0})
                if (!std::isfinite(angle.quantile(u))) fuzz::report("an angle is not finite");
        } else if (kind == "domain") {
            const auto shape = parseShape(text);
            if (!shape) return 0;
            const double volume = shape->space ? shape->space->volume() : shape->plane->volume();
            if (!(volume > 0) || !std::isfinite(volume)) fuzz::report("a shape without a volume");
        } else if (kind == "clip") {
            if (parseClip(text).planes.empty()) fuzz::report("a clip without a plane");
        } else if (kind == "slice") {
            if (!std::isfinite(parseSlice(text))) fuzz::report("a slice at no height");
        } else if (kind == "spacing") {
            for (const double s : parseVoxelSpacing(text).c)
                if (!(s > 0) || !std::isfinite(s)) fuzz::report("voxels without a distance");
        }
    } catch (const ResourceError& e) {
        fuzz::report(e.what());
    } catch (const Error& e) {
        if (*e.what() == '\0') fuzz::report("an error without a message");
    }
    return 0;
}
