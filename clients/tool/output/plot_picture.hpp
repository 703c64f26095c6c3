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

/// The appearance of a plot.
struct PlotStyle {
  std::string title;                           ///< any text, will be escaped
  std::string note{};                          ///< below the title
  std::uint64_t origin = 0;                    ///< tick at time 0
  std::chrono::nanoseconds period{1'000'000};  ///< of a tick
  std::uint32_t width = kUsualPlotWidth;       ///< [px]
  std::uint32_t height = 0;                    ///< [px]; 0 = from the number of panels
};

/// @return the number of panels that the columns need.
[[nodiscard]] std::size_t count_panels(const std::vector<PlotColumn>& columns);

/// @return the smallest height of a picture with this number of panels [px].
[[nodiscard]] std::uint32_t smallest_plot_height(std::size_t panels) noexcept;

/// @return the number of pixel columns for a curve: at most the width of the plot, and few enough
///         to keep the picture below some 300 kB.
[[nodiscard]] std::size_t plot_bins(std::uint32_t width, std::size_t columns) noexcept;

/// Draws an SVG: the power state as a band, below it a panel for each quantity, with ticks, units
/// and a legend, and a line at each fault. It has its own background and follows the light or dark
/// scheme of the viewer. Equal traces give identical bytes.
[[nodiscard]] std::string plot_svg(const PlotTraces& traces, const PlotStyle& style);

}  // namespace vdrive::tool
