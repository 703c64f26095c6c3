// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace vdrive::tool {

/// The order of the rows.
enum class WatchSort : std::uint8_t { axis, name, position, velocity, torque, state };

/// Which axes a table shows, and in which order.
struct WatchChoice {
  WatchSort sort = WatchSort::axis;  ///< velocity and torque: the largest amount first
  bool is_reversed = false;
  bool only_faults = false;
  std::size_t first = 0;  ///< row of the first axis that is shown; beyond the end: the last page
};

/// @return the face of an axis that is watched: it has one.
[[nodiscard]] const AxisFace& face_of(const client::AxisId& axis,
                                      const std::map<client::AxisId, AxisFace>& faces);

/// @return how many axes a page of this height has where not all of them fit.
[[nodiscard]] std::size_t page_of(const TerminalSize& size);

/// What `watch` shows on a terminal: a line with the tick, of several benches that of each, a
/// header, and one row an axis. A wider terminal gets more columns; 60 are enough for position,
/// velocity and state with the bits of the statusword. No row is wider than the terminal, and there
/// are no more rows than it has.
[[nodiscard]] std::vector<LiveLine> watch_table(const client::Observation& sample,
                                                const std::map<client::AxisId, AxisFace>& faces,
                                                const TerminalSize& size,
                                                const WatchChoice& choice = {});

}  // namespace vdrive::tool
