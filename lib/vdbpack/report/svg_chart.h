// Small charts as inline SVG, readable at the width of a phone.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// What is drawn in one color. Points that are not finite are left out.
struct ChartSeries {
    /// A line through points, or bars or an outline of steps over intervals.
    enum class Form { line, bars, steps };
    std::string name;  ///< in the legend; empty: not listed
    Form form = Form::line;
    std::vector<double> x;  ///< one per point; bars and steps: the n + 1 bounds of n intervals
    std::vector<double> y;
    std::vector<double> error;  ///< half of each error bar, of lines; empty: none
};

/// A level to compare with.
struct ChartLevel {
    std::string name;
    double y = 0;
};

struct Chart {
    std::string id;  ///< of the element in the page
    std::string title, xLabel, yLabel;
    std::string note;  ///< a sentence below, also for screen readers
    std::string none;  ///< shown instead of the chart if there are no data: the reason
    std::vector<ChartSeries> series;
    std::optional<ChartLevel> level;  ///< a dashed line across
    bool fromZero = false;            ///< the x axis starts at 0, as the y axis does
    bool wholeTicks = false;          ///< ticks of x at integers only
};

/// The chart as a <figure> of well-formed XML with its title, legend and note. The y axis starts
/// at 0; ticks are at round numbers. Colors and sizes come from `chartStyle`.
std::string figure(const Chart& chart);

/// The CSS of figures, needed once per page.
std::string chartStyle();

/// Multiples of 1, 2 or 5 times a power of ten within [low, high], at most `most` + 1 of them.
/// @param whole  integers only.
std::vector<double> roundTicks(double low, double high, int most, bool whole = false);

}  // namespace vdbpack
