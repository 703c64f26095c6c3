// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_follower.hpp"
#include "control_keeper.hpp"
#include "joints.hpp"
#include "limits_reader.hpp"
#include "reports.hpp"
#include "vdrive/client/session.hpp"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace vdrive::ros2 {

/// The axes of a bench in one tick.
struct BenchState {
  std::uint64_t tick = 0;
  std::vector<client::AxisSnapshot> axes;  ///< in the order of the joints
};

/// The connection to a bench: a thread follows its axes, takes control of them, and reads their
/// limits. Every call that waits for the bench is made there.
class BenchLink {
 public:
  /// @param session outlives the link
  /// @param notify runs in the thread of the link when there is a new state
  BenchLink(client::Session& session, client::BenchInfo info, std::vector<Joint> joints,
            bridge::Reports& reports, std::function<void()> notify);
  ~BenchLink() = default;
  BenchLink(const BenchLink&) = delete;
  BenchLink& operator=(const BenchLink&) = delete;

  [[nodiscard]] const client::BenchInfo& info() const noexcept { return info_; }

  [[nodiscard]] const std::vector<Joint>& joints() const noexcept { return joints_; }

  [[nodiscard]] std::string name() const { return "bench " + std::to_string(info_.number); }

  /// @return [s] of a tick
  [[nodiscard]] double period() const noexcept;

  /// @return the newest state; none while the bench sends no status.
  [[nodiscard]] std::shared_ptr<const BenchState> state() const;

  /// @return drive time over wall time; 1 where time does not pass by itself.
  [[nodiscard]] double rate() const noexcept { return rate_; }

  void set_rate(double rate) noexcept { rate_ = rate; }

  /// Gives the axes back that the session holds.
  void give_back();

  /// Whether this bridge wants to control all axes: see bridge::ControlKeeper.
  void want_control(bool wanted) { keeper_.want(wanted); }

  /// @return the limits of all joints; none before they were read.
  [[nodiscard]] LimitsReader::Limits limits() const { return limits_.limits(); }

  /// Has the limits read again. @return the value that limits_read() has after it.
  std::uint64_t request_limits() { return limits_.request(); }

  [[nodiscard]] std::uint64_t limits_read() const noexcept { return limits_.count(); }

 private:
  void run(const std::stop_token& stop);
  [[nodiscard]] client::Result<bridge::BenchFollower::Next> begin();
  void follow();
  void set_state(client::Observation&& observation);
  [[nodiscard]] bridge::ControlKeeper::Calls control_calls(bridge::Reports& reports);
  void keep_control();
  void read_limits();

  client::Session& session_;
  const client::BenchInfo info_;
  const std::vector<Joint> joints_;
  const std::function<void()> notify_;
  std::vector<client::AxisId> ids_;
  std::vector<client::Axis> axes_;
  bridge::BenchFollower follower_;
  bridge::ControlKeeper keeper_;
  LimitsReader limits_;
  std::atomic<double> rate_ = 1.0;
  std::atomic<bool> gives_back_ = false;
  mutable std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<const BenchState> state_;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
