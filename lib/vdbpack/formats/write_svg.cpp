// Scalable Vector Graphics: circles as a picture for browsers and papers.
#include "vdbpack/core/box.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/row_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

constexpr double kPixels = 900;   // longer side of the picture when it is opened
constexpr double kMargin = 0.01;  // around everything, as a fraction of the longer side
constexpr double kLine = 0.06;    // width of outlines divided by the mean radius
constexpr const char* kFrame = "#444";

/// Blue and sand differ for color-blind readers and in gray print. Each is outlined by its own dark
/// shade.
struct Colors {
    const char* name;
    const char* fill;
    const char* outline;
};
constexpr Colors kCortical{"cortical", "#4a78a8", "#1d3a5a"};
constexpr Colors kTrabecular{"trabecular", "#f0d9a0", "#8a6d2a"};

/// Numbers with as many decimals as resolve a millionth of the picture, without trailing zeros.
class NumberWriter {
public:
    explicit NumberWriter(double extent)
        : decimals_(std::clamp(5 - static_cast<int>(std::floor(std::log10(extent))), 0, 30)) {}

    void append(std::string& text, double value) const {
        const std::size_t begin = text.size();
        fmt::format_to(std::back_inserter(text), "{:.{}f}", value, decimals_);
        if (decimals_ > 0) {
            while (text.back() == '0') text.pop_back();
            if (text.back() == '.') text.pop_back();
        }
        if (text.compare(begin, std::string::npos, "-0") == 0) text.erase(begin, 1);
    }
    std::string operator()(double value) const {
        std::string text;
        append(text, value);
        return text;
    }

private:
    int decimals_;
};

/// Bounds of the picture and width of its lines, in the unit of the file.
struct Layout {
    Box<2> bounds;
    double line = 0;

    Layout(const PackView& pack, const Box<2>& frame) : bounds(frame) {
        double sum = 0;
        for (std::size_t i = 0; i < pack.size(); ++i) {
            const auto p = pack.position(i);
            const double r = pack.radius(i);
            bounds.add({{p[0] - r, p[1] - r}});
            bounds.add({{p[0] + r, p[1] + r}});
            sum += r;
        }
        if (bounds.empty()) bounds = {{{0, 0}}, {{1, 1}}};
        line = pack.size() > 0 ? kLine * sum / static_cast<double>(pack.size()) : kMargin * side();
        // Far from the origin, bounds may differ by less than a double resolves.
        const double farthest = std::max({std::abs(bounds.lo[0]), std::abs(bounds.lo[1]),
                                          std::abs(bounds.hi[0]), std::abs(bounds.hi[1])});
        bounds = bounds.grown(kMargin * side() + line + 1e-12 * farthest);
    }
    double side() const { return std::max(bounds.size()[0], bounds.size()[1]); }
};

}  // namespace

void writeSvg(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    Box<2> frame;
    if (options.frame)
        for (int d = 0; d < 2; ++d) {
            frame.lo[d] = fromMillimeters(options.frame->lo[d], pack.unit());
            frame.hi[d] = fromMillimeters(options.frame->hi[d], pack.unit());
        }
    const Layout layout(pack, frame);
    const NumberWriter number(layout.side());
    const Vec<2> size = layout.bounds.size();
    const double pixels = kPixels / layout.side();

    // y points down in SVG: cy = -y, so that coordinates can be read off the file.
    out.write(std::string("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"));
    out.write(
        fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0f}\" height=\"{:.0f}\" "
                    "viewBox=\"{} {} {} {}\">\n",
                    std::max(1.0, size[0] * pixels), std::max(1.0, size[1] * pixels),
                    number(layout.bounds.lo[0]), number(-layout.bounds.hi[1]), number(size[0]),
                    number(size[1])));
    out.write(fmt::format("<title>{} circles</title>\n<desc>y = -cy; {}{}", pack.size(),
                          kUnitComment, unitName(pack.unit())));
    if (!options.generator.empty())
        out.write(fmt::format("; {}: {}", kGeneratorKey, escapedXml(options.generator)));
    out.write(std::string("</desc>\n"));

    // One style per group: styles per circle would double the file.
    const auto writeGroup = [&](const Colors& colors, const std::vector<std::size_t>& circles) {
        if (circles.empty()) return;
        out.write(fmt::format("<g id=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\">\n",
                              colors.name, colors.fill, colors.outline, number(layout.line)));
        writeRows(out, circles.size(), [&](std::string& text, std::size_t row) {
            const auto p = pack.position(circles[row]);
            number.append(text += "<circle cx=\"", p[0]);
            number.append(text += "\" cy=\"", -p[1]);
            number.append(text += "\" r=\"", pack.radius(circles[row]));
            text += "\"/>\n";
        });
        out.write(std::string("</g>\n"));
    };
    std::vector<std::size_t> cortical, trabecular;
    for (std::size_t i = 0; i < pack.size(); ++i)
        (pack.region().empty() || pack.region()[i] == 0 ? cortical : trabecular).push_back(i);
    writeGroup(kTrabecular, trabecular);
    writeGroup(kCortical, cortical);
    if (options.frame)
        out.write(fmt::format(
            "<rect id=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" "
            "stroke=\"{}\" stroke-width=\"{}\"/>\n",
            number(frame.lo[0]), number(-frame.hi[1]), number(frame.size()[0]),
            number(frame.size()[1]), kFrame, number(layout.side() / kPixels)));
    out.write(std::string("</svg>\n"));
}

}  // namespace vdbpack
