// What the terminal, if it is one, can do.
#pragma once

#include <cstddef>
#include <string>

/// Whether a stream (1 output, 2 errors) is a terminal.
bool isTerminal(int stream);

/// Whether a stream shows colors: it is a terminal, and neither NO_COLOR nor
/// TERM=dumb speaks against it.
bool hasColor(int stream);

/// Columns to write in: those of the terminal between 60 and 120, elsewhere 80.
std::size_t columnsOf(int stream);

enum class Style { bold, red, yellow, green };

/// `text` in a style where the stream shows it, else as it is.
std::string styled(const std::string& text, Style style, int stream);
