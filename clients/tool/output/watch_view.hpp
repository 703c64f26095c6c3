// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "terminal/keys.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {

/// The sort order of the rows.
enum class WatchSort : std::uint8_t { axis, name, position, velocity, torque, state };

/// The axes that a table shows, and their order.
struct WatchChoice {
  WatchSort sort = WatchSort::axis;  ///< velocity and torque: largest amount first
  bool is_reversed = false;
  bool only_faults = false;
  std::size_t first = 0;  ///< row of the first axis shown; beyond the end: the last page
};

/// @return the label of a watched axis.
/// @pre `labels` has it
[[nodiscard]] const AxisLabel& label_of(const client::AxisId& axis,
                                        const std::map<client::AxisId, AxisLabel>& labels);

/// @return the number of axes per page if they do not all fit.
[[nodiscard]] std::size_t page_of(const TerminalSize& size);

/// The table of `watch` on a terminal: a line with the tick of each bench, a header, and one row
/// per axis. A wider terminal gets more columns; 60 are enough for position, velocity and state
/// with the bits of the statusword. The table never exceeds the size of the terminal.
[[nodiscard]] std::vector<LiveLine> watch_table(const client::Observation& sample,
                                                const std::map<client::AxisId, AxisLabel>& labels,
                                                const TerminalSize& size,
                                                const WatchChoice& choice = {});

/// Shows samples of axes: as a table that fills a terminal and follows its size, or as lines. Takes
/// every sample, and shows the newest one of each bench at most every 50 ms, as lines every 100 ms.
class WatchView {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Form : std::uint8_t { table, lines, json };

  WatchView(Terminal& terminal, std::map<client::AxisId, AxisLabel> labels, Form form)
      : terminal_(terminal), labels_(std::move(labels)), form_(form) {}

  /// @param sample of axes of one bench
  void take(client::Observation sample);

  /// Handles a key. @return false for the key that ends the view.
  bool press(Key key);

  /// Shows the newest sample if it is due, and either the sample or the size of the terminal is
  /// new. Lines equal to those shown last are not new.
  /// @return whether it was shown.
  bool refresh(Clock::time_point now);

 private:
  void show_table();
  [[nodiscard]] bool show_lines();
  [[nodiscard]] std::string line_of(const client::AxisSnapshot& axis) const;
  [[nodiscard]] client::Observation all() const;

  Terminal& terminal_;
  const std::map<client::AxisId, AxisLabel> labels_;
  const Form form_;
  std::map<std::uint32_t, client::Observation> newest_;  ///< by bench
  bool is_new_ = false;
  WatchChoice choice_;
  bool choice_changed_ = false;
  TerminalSize shown_size_;
  std::vector<std::string> shown_lines_;
  Clock::time_point due_;
};

}  // namespace vdrive::tool
