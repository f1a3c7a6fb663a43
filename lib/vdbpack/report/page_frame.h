// What all pages for the browser have in common.
#pragma once

#include <string>

namespace vdbpack {

struct PagePicture;

/// A <figure> with the picture and the view; empty if there is neither.
std::string pictureFigure(const PagePicture& picture);

/// A page that is also well-formed XML.
/// @param title  plain text. @param style  added to that of all pages. @param main  markup
std::string htmlPage(const std::string& title, const std::string& style, const std::string& main);

/// Whether a report is a page for the browser, which shows more of a pack than each run measures.
bool isPage(const std::string& reportFile);

}  // namespace vdbpack
