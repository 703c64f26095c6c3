// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "bench_follower.hpp"
#include "control_keeper.hpp"
#include "reports.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

namespace vdrive::ros2 {

/// The connection to a bench: a thread follows its axes, takes control of them, and reads their
/// limits. Every call that waits for the bench is made there.
class BenchLink {
 public:
  /// @param session outlives the link, as `bench` and `reports` do
  /// @param notify runs in the thread of the link when there is a new state
  BenchLink(client::Session& session, Bench& bench, bridge::Reports& reports,
            std::function<void()> notify);

 private:
  void run(const std::stop_token& stop);
  [[nodiscard]] client::Result<bridge::BenchFollower::Next> begin();
  void follow();
  [[nodiscard]] std::optional<client::Observation> ask_again();
  void set_state(client::Observation&& observation);
  void learn_names(std::span<const client::AxisSnapshot> axes);
  [[nodiscard]] bridge::ControlKeeper::Calls control_calls(bridge::Reports& reports);
  void keep_control(std::optional<ControlWish> wish);
  void read_limits(std::uint64_t request);

  client::Session& session_;
  Bench& bench_;
  const std::function<void()> notify_;
  std::vector<client::AxisId> ids_;
  std::vector<client::Axis> axes_;
  bridge::BenchFollower follower_;
  bridge::ControlKeeper keeper_;
  std::chrono::steady_clock::time_point limits_due_{};
  std::chrono::steady_clock::time_point opened_{};   ///< when it began to follow
  std::chrono::steady_clock::time_point ask_due_{};  ///< for a state that the stream did not show
  std::jthread thread_;                              ///< last: it uses all others
};

}  // namespace vdrive::ros2
