// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "terminal.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace vdrive::tool {

/// Shows samples of axes: as a table that fills a terminal and follows its size, or as lines.
/// Takes every sample and shows the newest one at most every 50 ms, as lines every 100 ms.
class WatchView {
 public:
  enum class Form : std::uint8_t { table, lines, json };

  WatchView(Terminal& terminal, std::map<client::AxisId, std::string> names, Form form)
      : terminal_(terminal), names_(std::move(names)), form_(form) {}

  void take(client::Observation sample);

  /// Shows the newest sample when it is new, or the terminal has another size, and time is due.
  /// @return whether it did.
  bool refresh();

 private:
  void show();

  Terminal& terminal_;
  const std::map<client::AxisId, std::string> names_;
  const Form form_;
  client::Observation newest_;
  bool is_new_ = false;
  TerminalSize shown_size_;
  std::chrono::steady_clock::time_point due_;
};

}  // namespace vdrive::tool
