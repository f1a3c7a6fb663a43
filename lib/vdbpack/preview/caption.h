// Private to previews: the scale bar, the legend and the sides that stand below a scene.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/preview/scale_bar.h"
#include "vdbpack/preview/sphere_colors.h"

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// A side that a picture names, and the way to it: x to the right, y up; the more it points at the
/// viewer, the shorter.
struct Side {
    std::string name;
    Vec<2> along;
};

/// The sides of the first axes of the world that one sees; of an axis across the view its positive
/// side, of a patient both.
/// @param camera  its directions are used.
std::vector<Side> seenSides(const PreviewCamera& camera, int axes, const PreviewOptions& options);

/// The scale bar, the legend and the sides, laid out for a picture of some size. Immutable.
class Caption {
public:
    /// @param width, height  of the picture, pixels.
    /// @param dot  pixels along a side of a letter's dot, less where they take too much room.
    Caption(Legend legend, std::vector<Side> sides, int width, int height, int dot);

    int width() const { return width_; }
    int height() const { return height_; }
    /// Rows of pixels left to the scene.
    int sceneHeight() const { return height_ - strip_; }
    int stripHeight() const { return strip_; }
    int dot() const { return dot_; }  ///< pixels along a side of a letter's dot

    /// A white picture with the caption drawn, but no scene.
    /// @param mmPerPixel  the scale that the scale bar shows.
    Picture drawn(double mmPerPixel) const;
    /// Colors, sides and scale in words.
    std::string words(double mmPerPixel, const std::vector<std::string>& more) const;

private:
    struct Place {
        int x = -1, line = 0;  ///< dots from the left; -1: left out for lack of room
    };
    /// The columns that the items take in lines one below the other.
    /// @param bar  dots that the scale bar takes with its length.
    std::vector<Place> flow(int bar, int& lines) const;
    /// Leaves out kinds for which there is no room, the last ones first.
    void leaveOutKinds(int bar);
    int rampDots() const;
    void drawLegend(const std::vector<Place>& places, int feet, Picture& image) const;
    void drawSides(Picture& image) const;

    Legend legend_;
    std::vector<Side> sides_;
    std::vector<Vec<2>> letters_;  ///< middles of their letters, dots from that of the cross, y up
    int width_, height_;
    int dot_;          ///< pixels along a side of a dot, the unit of all distances here
    int columns_ = 0;  ///< dots along a line
    int mostLines_ = 0;
    bool hasBar_ = false;
    int strip_ = 0;  ///< pixels
    Box<2> cross_;   ///< around the letters of the sides, dots from the middle, y up
};

/// The caption of a picture of the requested size, or of one that is fitted to its scene.
/// @param aspect  width divided by height of the scene.
Caption captionFor(const Legend& legend, const std::vector<Side>& sides,
                   const PreviewOptions& options, double aspect);

}  // namespace vdbpack
