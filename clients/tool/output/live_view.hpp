// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "terminal/terminal.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::tool {

/// Shows axes of one bench while commands are executed: on a terminal as a block refreshed in
/// place, with a bar for a move whose target is known; otherwise one line per second of drive time.
/// Follows the status stream in its own thread from construction to destruction.
class LiveView {
 public:
  LiveView(client::Session& session, Terminal& terminal, std::vector<client::AxisId> axes);
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// The axis moves to this position, from the last one seen.
  void aim(const client::AxisId& axis, std::int64_t target);

 private:
  struct Aim {
    std::int64_t start = 0;
    std::int64_t target = 0;
  };

  void follow(const std::stop_token& stop);
  void note(const client::Observation& sample);
  void show(const client::Observation& sample);
  [[nodiscard]] std::string bar_of(const client::AxisSnapshot& axis);

  client::Session& session_;
  Terminal& terminal_;
  std::vector<client::AxisId> axes_;
  std::mutex mutex_;
  std::map<client::AxisId, Aim> aims_;
  std::map<client::AxisId, std::int64_t> positions_;
  std::map<client::AxisId, client::Unit> units_;
  std::uint64_t ticks_per_line_ = 1000;
  std::uint64_t next_line_ = 0;  ///< tick
  std::jthread thread_;
};

/// @return a bar of `width` columns, such as "[######------]".
[[nodiscard]] std::string progress_bar(double fraction, std::size_t width);

}  // namespace vdrive::tool
