#include "vdbpack/preview/caption.h"

#include "vdbpack/preview/bitmap_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdbpack {

namespace {

/// Pixels of a square picture along a side for each pixel of a dot; small ones have larger dots.
constexpr double kDotSide = 450, kSmallDots = 0.8;
/// Largest share of a picture's height for the caption, and limits of the shape of a fitted one.
constexpr double kMostShare = 0.4, kMostAspect = 3;
/// Pixels of the shortest side.
constexpr int kShortest = 16;
/// Distances in dots: around the caption, from line to line, between scale bar, legend and cross,
/// between named colors and within an item.
constexpr int kBorder = 4, kLine = 14, kItemGap = 14, kKindGap = 7, kGap = 3;
/// Dots that the length of a scale bar takes at most, but for rare ones: "0.05 mm".
constexpr int kBarText = 7 * (kLetterWidth + 1);
/// Share of the width that a scale bar may take, and the color bar; and its shortest length, dots.
constexpr double kBarShare = 0.25, kRampShare = 0.2;
constexpr int kShortestRamp = 20;
/// Dots: length of an arm of the cross, from its end to the middle of its letter, half its width.
constexpr double kArm = 8, kToLetter = 6, kArmWidth = 0.6;
/// Where a side faces the viewer, its letter takes the middle, and arms run from there to here.
constexpr double kClear = 7, kShortArm = 12;
/// An axis that points at the viewer by less lies across the view, and one of whose length less
/// than this is seen faces the viewer.
constexpr double kAcross = 0.02, kShort = 0.02;

bool facesViewer(const Side& side) {
    return length(side.along) < kShort;
}

/// Where the arms of a cross begin and end, dots, for a side seen in full length.
std::array<double, 2> armsOf(const std::vector<Side>& sides) {
    const bool any = std::any_of(sides.begin(), sides.end(), facesViewer);
    return any ? std::array{kClear, kShortArm} : std::array{0.0, kArm};
}

/// The middles of the letters, dots from that of the cross, y up.
std::vector<Vec<2>> lettersOf(const std::vector<Side>& sides) {
    const double arm = armsOf(sides)[1];
    std::vector<Vec<2>> letters;
    for (const Side& side : sides) {
        const double seen = length(side.along);
        letters.push_back(facesViewer(side) ? Vec<2>{}
                                            : side.along * ((arm * seen + kToLetter) / seen));
    }
    return letters;
}

/// Colors the pixels of a rectangle as `colorOf(share of its width)` says, in a frame of ink.
template <class ColorOf>
void drawSwatch(int left, int top, int width, int height, int frame, const ColorOf& colorOf,
                Picture& image) {
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool inside = std::min({x, y, width - 1 - x, height - 1 - y}) >= frame;
            toSrgb(inside ? colorOf((x + 0.5) / width) : inkColor(),
                   image.pixel(left + x, top + y));
        }
}

std::string moreKinds(const Legend& legend) {
    return fmt::format("and {} more", legend.more);
}

/// Pixels of a dot in a picture of that size.
int dotOf(double width, double height) {
    return std::max(
        1, static_cast<int>(std::lround(kSmallDots + std::sqrt(width * height) / kDotSide)));
}

}  // namespace

SideNames sideNames(const PreviewOptions& options) {
    return !options.ofPatient                 ? SideNames{{{"x", "-x"}, {"y", "-y"}, {"z", "-z"}}}
           : options.space == ImageSpace::lps ? SideNames{{{"L", "R"}, {"P", "A"}, {"S", "I"}}}
                                              : SideNames{{{"R", "L"}, {"A", "P"}, {"S", "I"}}};
}

std::vector<Side> seenSides(const PreviewCamera& camera, int axes, const PreviewOptions& options) {
    const SideNames names = sideNames(options);
    std::vector<Side> sides;
    for (int k = 0; k < axes; ++k)
        for (const std::size_t end : {0u, 1u}) {
            const double sign = end == 0 ? 1 : -1;
            const bool across = std::fabs(camera.toward[k]) < kAcross;
            if (across ? end == 0 || options.ofPatient : sign * camera.toward[k] > 0)
                sides.push_back({names[static_cast<std::size_t>(k)][end],
                                 Vec<2>{{camera.right[k], camera.up[k]}} * sign});
        }
    return sides;
}

Caption::Caption(Legend legend, std::vector<Side> sides, int width, int height, int dot)
    : legend_(std::move(legend)),
      sides_(std::move(sides)),
      width_(width),
      height_(height),
      dot_(dot) {
    cross_.add({});
    letters_ = lettersOf(sides_);
    for (std::size_t k = 0; k < sides_.size(); ++k) {
        const Vec<2> half{{textDots(sides_[k].name) / 2.0, kLetterHeight / 2.0 + kHang}};
        cross_.add(letters_[k] - half);
        cross_.add(letters_[k] + half);
    }
    const int across = static_cast<int>(std::ceil(cross_.size()[0])) + kItemGap;
    int most = 0, bar = 0;
    for (;; --dot_) {
        most = static_cast<int>(kMostShare * height) / dot_ - 2 * kBorder;
        columns_ = width / dot_ - 2 * kBorder;
        bar = static_cast<int>(kBarShare * width / dot_) + kGap + kBarText;
        const bool fits = cross_.size()[1] <= most && bar + across <= columns_;
        if (!fits && dot_ > 1) continue;  // smaller letters
        if (!fits) sides_.clear();
        break;
    }
    if (!sides_.empty()) columns_ -= across;
    mostLines_ = (most + kLine - kLetterHeight - kHang) / kLine;
    for (Legend::Kind& kind : legend_.kinds) {
        const int letters = (columns_ - kLetterHeight - kGap) / (kLetterWidth + 1);
        if (static_cast<int>(kind.name.size()) > letters)
            kind.name =
                kind.name.substr(0, static_cast<std::size_t>(std::max(letters - 2, 0))) + "..";
    }
    leaveOutKinds(bar);
    hasBar_ = flow(bar, mostLines_).front().x >= 0;
    const int text = mostLines_ == 0 ? 0 : mostLines_ * kLine - (kLine - kLetterHeight - kHang);
    const int cross = sides_.empty() ? 0 : static_cast<int>(std::ceil(cross_.size()[1]));
    strip_ = text + cross == 0 ? 0 : (std::max(text, cross) + 2 * kBorder) * dot_;
}

void Caption::leaveOutKinds(int bar) {
    const auto fits = [&] {
        int lines = 0;
        const auto places = flow(bar, lines);
        return std::all_of(places.begin(), places.end(), [](const Place& p) { return p.x >= 0; });
    };
    while (legend_.kinds.size() > 1 && !fits()) {
        legend_.kinds.pop_back();
        ++legend_.more;
    }
}

int Caption::rampDots() const {
    const int ends = textDots(legend_.ends[0]) + textDots(legend_.ends[1]) + 2 * kGap;
    return std::max(kShortestRamp,
                    std::min(static_cast<int>(kRampShare * width_ / dot_), columns_ - ends));
}

std::vector<Caption::Place> Caption::flow(int bar, int& lines) const {
    std::vector<int> items{bar};
    const bool titled = !legend_.title.empty();
    if (titled) items.push_back(textDots(legend_.title));
    for (const Legend::Kind& kind : legend_.kinds)
        items.push_back(kLetterHeight + kGap + textDots(kind.name));
    if (legend_.more > 0) items.push_back(textDots(moreKinds(legend_)));
    if (titled && legend_.kinds.empty())
        items.push_back(textDots(legend_.ends[0]) + textDots(legend_.ends[1]) + 2 * kGap +
                        rampDots());
    // The legend stands in one line where it fits into one, else its title beside what follows.
    const int gap = legend_.kinds.empty() ? kItemGap : kKindGap;
    int together = -gap;
    for (std::size_t k = 1; k < items.size(); ++k) together += items[k] + gap;
    if (together > columns_ && titled) together = items[1] + gap + items[2];
    const int most = mostLines_;
    std::vector<Place> places;
    int x = 0, line = 0;
    lines = 0;
    for (std::size_t k = 0; k < items.size(); ++k) {
        const int item = items[k];
        const int needed = k == 1 && together <= columns_ ? together : item;
        const bool next = x > 0 && x + needed > columns_;
        if (item > columns_ || line + next >= most) {
            places.push_back({});
            continue;
        }
        if (next) x = 0, ++line;
        places.push_back({x, line});
        lines = line + 1;
        x += item + (k == 0 ? kItemGap : gap);
    }
    if (titled && places[2].x < 0) places[1].x = -1;
    return places;
}

Picture Caption::drawn(double mmPerPixel) const {
    Picture image;
    image.width = width_;
    image.height = height_;
    image.pixels.assign(3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_),
                        255);
    if (strip_ == 0) return image;
    const ScaleBar bar = scaleBarFor(mmPerPixel, width_);
    const double pixels = bar.length / mmPerPixel;
    const int barDots = static_cast<int>(std::ceil(pixels / dot_));
    int lines = 0;
    const auto places = flow(barDots + kGap + textDots(bar.words()), lines);
    const int text = (lines * kLine - (kLine - kLetterHeight - kHang)) * dot_;
    const int top = height_ - strip_ / 2 - text / 2, feet = top + kLetterHeight * dot_;
    if (places[0].x >= 0 && bar.length > 0) {
        const int left = kBorder * dot_;
        drawScaleBar(bar, pixels, left, feet - 5 * dot_, feet - 2 * dot_, image);
        drawText(bar.words(), left + (barDots + kGap) * dot_, feet, dot_, image);
    }
    drawLegend(places, feet, image);
    if (!sides_.empty()) drawSides(image);
    return image;
}

void Caption::drawLegend(const std::vector<Place>& places, int feet, Picture& image) const {
    const int frame = std::max(1, dot_ / 3), high = kLetterHeight * dot_;
    const auto write = [&](const std::string& text, int x, int at) {
        drawText(text, x, at, dot_, image);
        return x + (textDots(text) + kGap) * dot_;
    };
    std::size_t next = 1;
    // The place of the next item in pixels; nothing: it is left out.
    const auto place = [&]() -> std::optional<std::array<int, 2>> {
        const Place& at = places[next++];
        if (at.x < 0) return {};
        return std::array{(kBorder + at.x) * dot_, feet + at.line * kLine * dot_};
    };
    if (!legend_.title.empty())
        if (const auto at = place()) write(legend_.title, (*at)[0], (*at)[1]);
    for (const Legend::Kind& kind : legend_.kinds)
        if (const auto at = place()) {
            const auto color = [&](double) { return kind.color; };
            drawSwatch((*at)[0], (*at)[1] - high, high, high, frame, color, image);
            write(kind.name, (*at)[0] + high + kGap * dot_, (*at)[1]);
        }
    if (legend_.more > 0)
        if (const auto at = place()) write(moreKinds(legend_), (*at)[0], (*at)[1]);
    if (!legend_.kinds.empty() || legend_.title.empty()) return;
    if (const auto at = place()) {
        const int left = write(legend_.ends[0], (*at)[0], (*at)[1]), wide = rampDots() * dot_;
        drawSwatch(left, (*at)[1] - high, wide, high, frame, rampColor, image);
        write(legend_.ends[1], left + wide + kGap * dot_, (*at)[1]);
    }
}

void Caption::drawSides(Picture& image) const {
    // From dots about the middle of the cross, y up, to pixels.
    const Vec<2> middle{{width_ - (kBorder + cross_.hi[0]) * dot_,
                         height_ - strip_ / 2 + (cross_.hi[1] + cross_.lo[1]) / 2 * dot_}};
    const auto inPixels = [&](const Vec<2>& x) {
        return middle + Vec<2>{{x[0] * dot_, -x[1] * dot_}};
    };
    const auto arms = armsOf(sides_);
    for (std::size_t k = 0; k < sides_.size(); ++k) {
        const Side& side = sides_[k];
        if (!facesViewer(side))
            drawStroke(inPixels(side.along * arms[0]), inPixels(side.along * arms[1]),
                       kArmWidth * dot_, image);
        const Vec<2> letter = inPixels(letters_[k]);
        drawText(side.name, static_cast<int>(letter[0] - textDots(side.name) * dot_ / 2.0),
                 static_cast<int>(letter[1] + kLetterHeight * dot_ / 2.0), dot_, image);
    }
}

std::string Caption::words(double mmPerPixel, const std::vector<std::string>& more) const {
    std::string text = legend_.words;
    const auto add = [&](const std::string& words) { text += (text.empty() ? "" : "; ") + words; };
    for (const std::string& words : more) add(words);
    std::string letters;
    for (const Side& side : sides_) letters += (letters.empty() ? "sides " : ", ") + side.name;
    if (!letters.empty()) add(letters);
    const ScaleBar bar = scaleBarFor(mmPerPixel, width_);
    if (hasBar_) add(fmt::format("scale bar {:g} mm in {} parts", bar.length, bar.parts));
    add(fmt::format("scene in the upper {} of {} rows", sceneHeight(), height_));
    return text;
}

Caption captionFor(const Legend& legend, const std::vector<Side>& sides,
                   const PreviewOptions& options, double aspect) {
    if (options.height > 0)
        return {legend, sides, options.width, options.height, dotOf(options.width, options.height)};
    aspect = std::clamp(aspect, 1 / kMostAspect, kMostAspect);
    const double longer = options.width;
    const auto pixels = [](double side) {
        return std::max(kShortest, static_cast<int>(std::lround(side)));
    };
    const double width = std::min(longer, longer * aspect), scene = width / aspect;
    // The caption's height follows the width, and both share the height of the picture.
    Caption caption(legend, sides, pixels(width), pixels(scene), dotOf(width, scene));
    for (int step = 0; step < 4; ++step) {
        const double shrink = std::min(1.0, (longer - caption.stripHeight()) / scene);
        caption = Caption(legend, sides, pixels(width * shrink),
                          pixels(scene * shrink + caption.stripHeight()), caption.dot());
    }
    return caption;
}

}  // namespace vdbpack
