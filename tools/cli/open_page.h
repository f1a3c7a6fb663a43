// Opens pages in the browser of the desktop.
#pragma once

#include <string>

/// Asks the desktop (xdg-open) to open a file, and does not wait for it.
/// @return whether there is a display, and a program that took the request.
bool openPage(const std::string& file);
