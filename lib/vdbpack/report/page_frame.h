// What all pages for the browser have in common.
#pragma once

#include <string>

namespace vdbpack {

/// A picture, and a view that takes its place where the browser can draw it.
struct PagePicture {
    std::string png;            ///< bytes of a file; empty: none
    int width = 0, height = 0;  ///< pixels
    std::string words;          ///< what it shows
    std::string viewStyle;      ///< for the head of the page, and
    std::string view;           ///< for the figure; empty: none
};

/// A <figure> with the picture and the view; empty if there is neither.
std::string pictureFigure(const PagePicture& picture);

/// A page that is also well-formed XML.
/// @param title  plain text. @param style  added to that of all pages. @param main  markup
std::string htmlPage(const std::string& title, const std::string& style, const std::string& main);

/// Whether a report is a page for the browser, which shows more of a pack than each run measures.
bool isPage(const std::string& reportFile);

}  // namespace vdbpack
