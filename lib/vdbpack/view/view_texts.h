// Private to views: style and script, compiled in from view.css and the .js files.
#pragma once

#include <vector>

namespace vdbpack {

extern const char* const kViewStyle;

/// The parts of the script, which share one scope, in order.
extern const std::vector<const char*> kViewScripts;

}  // namespace vdbpack
