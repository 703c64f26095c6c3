// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"
#include "joints.hpp"
#include "reports.hpp"
#include "vdrive/client/session.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
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

/// @return a session other than `own` that controls an axis; nothing when there is none.
[[nodiscard]] std::optional<std::uint64_t> other_owner(const BenchState& state, std::uint64_t own);

/// The connection to a bench: a thread follows its axes, takes control of them, and reads their
/// limits. Every call that waits for the bench is made there.
class BenchLink {
 public:
  /// @param session outlives the link
  /// @param notify runs in the thread of the link when there is a new state
  BenchLink(client::Session& session, client::BenchInfo info, std::vector<Joint> joints,
            Reports& reports, std::function<void()> notify);
  ~BenchLink();
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

  /// Takes control of all axes as soon as no other session controls one of them, and again when it
  /// was lost; or takes none any more. The owner that it waits for is reported once.
  void want_control(bool wanted);

  /// @return the limits of all joints; none before they were read.
  [[nodiscard]] std::shared_ptr<const std::vector<JointLimits>> limits() const;

  /// Has the limits read again. @return the value that limits_read() has after it.
  std::uint64_t request_limits();

  [[nodiscard]] std::uint64_t limits_read() const noexcept { return limits_read_; }

 private:
  void run(const std::stop_token& stop);
  bool open_follower();
  void follow();
  void set_state(client::Observation&& observation);
  void take_control();
  void wait_for_owner(const BenchState& state, std::uint64_t owner);
  void report_control(const BenchState& state);
  [[nodiscard]] bool is_held(const BenchState& state) const;
  void read_limits();
  [[nodiscard]] static std::optional<JointLimits> limits_of(client::Axis& axis, const Joint& joint);
  void rest(std::chrono::milliseconds duration, const std::stop_token& stop);

  client::Session& session_;
  const client::BenchInfo info_;
  const std::vector<Joint> joints_;
  Reports& reports_;
  const std::function<void()> notify_;
  std::vector<client::AxisId> ids_;
  std::vector<client::Axis> axes_;
  std::optional<client::Follower> follower_;
  std::chrono::steady_clock::time_point limits_due_{};
  std::chrono::steady_clock::time_point control_due_{};
  std::chrono::milliseconds control_retry_{};
  std::uint64_t reported_owner_ = 0;  ///< session that control waits for; 0 = it does not wait
  std::string reported_refusal_;
  std::atomic<double> rate_ = 1.0;
  std::atomic<bool> wants_control_ = false;
  std::atomic<bool> gives_back_ = false;
  std::atomic<bool> is_control_new_ =
      false;  ///< it is wanted again: what was reported is reported again
  std::atomic<std::uint64_t> limits_requested_ = 0;
  std::atomic<std::uint64_t> limits_read_ = 0;
  mutable std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<const BenchState> state_;
  std::shared_ptr<const std::vector<JointLimits>> limits_;
  std::condition_variable_any woken_;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
