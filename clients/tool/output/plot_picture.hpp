// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/plot_columns.hpp"
#include "output/plot_traces.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::tool {

inline constexpr std::uint32_t kUsualPlotWidth = 960;     // [px]
inline constexpr std::uint32_t kSmallestPlotWidth = 320;  // [px]
inline constexpr std::uint32_t kLargestPlotSide = 4000;   // [px]

/// How a plot is drawn.
struct PlotFace {
  std::string title;                           ///< any text; it is escaped
  std::string note{};                          ///< below the title
  std::uint64_t origin = 0;                    ///< tick of the time 0
  std::chrono::nanoseconds period{1'000'000};  ///< of a tick
  std::uint32_t width = kUsualPlotWidth;       ///< [px]
  std::uint32_t height = 0;                    ///< [px]; 0 = by the number of panels
};

/// @return how many panels the columns take.
[[nodiscard]] std::size_t count_panels(const std::vector<PlotColumn>& columns);

/// @return the least height of a picture with this number of panels [px].
[[nodiscard]] std::uint32_t smallest_plot_height(std::size_t panels) noexcept;

/// @return how many columns of pixels a curve gets: no more than the plot has, and so few that the
///         picture stays below some 300 kB.
[[nodiscard]] std::size_t plot_bins(std::uint32_t width, std::size_t columns) noexcept;

/// Draws an SVG: the power state as a band, below it a panel for each quantity, with ticks, units
/// and a legend, and a line at each fault. It has its own paper and follows the light or dark
/// scheme of the viewer. The same traces give the same bytes.
[[nodiscard]] std::string plot_svg(const PlotTraces& traces, const PlotFace& face);

}  // namespace vdrive::tool
