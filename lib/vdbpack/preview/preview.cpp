// Options of pictures: their texts and their checks.
#include "vdbpack/preview/preview.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

namespace vdbpack {

namespace {

constexpr int kSmallest = 16, kLargest = 16384;

[[noreturn]] void malformed(const std::string& name, const std::string& text, const char* form) {
    throw ParameterError(fmt::format("{} '{}' is malformed; write {}", name, text, form));
}

}  // namespace

PreviewCut parsePreviewCut(const std::string& text) {
    const char* form = "x=V, y=V or z=V, in mm";
    PreviewCut cut;
    if (text.size() < 3 || text[0] < 'x' || text[0] > 'z' || text[1] != '=')
        malformed("`preview.cut`", text, form);
    cut.axis = text[0] - 'x';
    const char* const end = text.data() + text.size();
    const auto [next, failed] = std::from_chars(text.data() + 2, end, cut.at);
    if (failed != std::errc() || next != end || !std::isfinite(cut.at))
        malformed("`preview.cut`", text, form);
    return cut;
}

PreviewView parsePreviewView(const std::string& text) {
    static const std::map<std::string, Vec<3>> sides{
        {"front", {{0, -1, 0}}}, {"back", {{0, 1, 0}}}, {"left", {{1, 0, 0}}},
        {"right", {{-1, 0, 0}}}, {"top", {{0, 0, 1}}},  {"bottom", {{0, 0, -1}}}};
    if (const auto side = sides.find(text); side != sides.end()) return {side->second, true};
    const auto numbers = parseNumberList(text);
    PreviewView view;
    if (numbers && numbers->size() == 3) std::copy_n(numbers->begin(), 3, view.from.c.begin());
    if (!isFinite(view.from) || !(length(view.from) > 0))
        malformed("`preview.view`", text,
                  "front, back, left, right, top, bottom, or the direction X,Y,Z to the viewer, "
                  "like 1,-1,0.5");
    return view;
}

std::array<int, 2> parsePreviewSize(const std::string& text) {
    const char* form = "WxH in pixels, like 1600x1200, or the longer side alone, like 1600";
    std::array<int, 2> size{};
    const char* const end = text.data() + text.size();
    const auto [cross, noWidth] = std::from_chars(text.data(), end, size[0]);
    if (noWidth != std::errc() || (cross != end && *cross != 'x'))
        malformed("`preview.width`", text, form);
    if (cross != end) {
        const auto [next, noHeight] = std::from_chars(cross + 1, end, size[1]);
        if (noHeight != std::errc() || next != end || size[1] == 0)
            malformed("`preview.width`", text, form);
    }
    checkPreviewSize(size[0], size[1]);
    return size;
}

void checkPreviewSize(int width, int height) {
    const int other = height == 0 ? width : height;
    if (std::min(width, other) < kSmallest || std::max(width, other) > kLargest)
        throw ParameterError(
            fmt::format("`preview.width` {}x{}: width and height must be {} to {} pixels", width,
                        height, kSmallest, kLargest));
}

void checkPreviewCut(const PreviewCut& cut, const Box<3>& bounds) {
    if (cut.axis < 0 || cut.axis > 2 || !std::isfinite(cut.at))
        throw ParameterError(fmt::format(
            "preview: no plane cuts axis {} at {} mm; axes are 0, 1 and 2", cut.axis, cut.at));
    if (!(cut.at > bounds.lo[cut.axis] && cut.at < bounds.hi[cut.axis]))
        throw ParameterError(
            fmt::format("`preview.cut` {0}={1:g}: misses the scene, which lies between {0} = "
                        "{2:.6g} and {3:.6g} mm; cut between them",
                        "xyz"[cut.axis], cut.at, bounds.lo[cut.axis], bounds.hi[cut.axis]));
}

}  // namespace vdbpack
