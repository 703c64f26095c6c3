// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "output/plot_columns.hpp"
#include "output/plot_picture.hpp"
#include "values/value.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Draws one axis of a recording.
struct PlotCommand {
  std::string source{};                   ///< the file of a recording, or an axis to record
  std::string picture{};                  ///< the file of the picture, - = standard output
  std::string shown_axis{};               ///< of the recording; empty = its only one
  std::vector<PlotColumn> columns{};      ///< what is drawn, one or more
  std::optional<Duration> from{};         ///< drive time since the first sample of the axis
  std::optional<Duration> to{};           ///< likewise
  std::optional<Duration> period{};       ///< of a tick, where the recording has no such time
  std::optional<Duration> duration{};     ///< drive time to record; none = `source` is a file
  std::uint32_t width = kUsualPlotWidth;  ///< [px]
  std::uint32_t height = 0;               ///< [px]; 0 = by the number of panels
  std::string title{};                    ///< empty = the axis

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;
};

}  // namespace vdrive::tool
