// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "axis_jobs.hpp"
#include "bench_control.hpp"
#include "bench_follower.hpp"
#include "reports.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "worker.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::bridge {

class BenchLink;

/// The part of a bridge that handles a bench. Called on the thread of the link, which may wait for
/// the bench. A final class with its link as the last member gets no call before its other members
/// exist, and none once their destruction has started.
class BenchAdapter {
 public:
  /// Axes in the order of BenchInfo::axes.
  using State = std::shared_ptr<const client::Observation>;

  virtual ~BenchAdapter() = default;

  /// The bench has appeared or reappeared; its first state follows.
  virtual void on_open(const client::BenchInfo& /*info*/,
                       const std::vector<client::Axis>& /*axes*/) {}

  /// The bench has a newer state.
  virtual void on_state(const State& state) = 0;

  /// The bench is silent or has ended.
  virtual void on_lost() = 0;

  /// Called before each wait for a new state (at most 10 ms), to pass requests to the link.
  virtual void before_turn(BenchLink& /*link*/) {}
};

/// The connection to a bench whose clock others advance: its threads follow the axes, keep control
/// of them, send set-points and run jobs. Only these threads wait for the bench. The destructor
/// waits for the call in progress.
class BenchLink final {
 public:
  using Job = std::function<void(client::Axis& axis)>;

  /// Frames of set-points that may wait for the bench; beyond that, the oldest are dropped.
  static constexpr std::size_t kMostWaitingFrames = 1'024;

  /// @param adapter, session, reports must outlive this
  BenchLink(BenchAdapter& adapter, client::Session& session, Reports& reports,
            const client::BenchInfo& info, BenchControl::Options control);
  ~BenchLink() = default;
  BenchLink(const BenchLink&) = delete;
  BenchLink& operator=(const BenchLink&) = delete;

  // Any thread; these do not wait.

  /// Sets whether control of all axes is wanted from now on. Calling this again after a loss takes
  /// control again.
  void want_control(bool wanted) { control_.want(wanted); }

  /// Queues a job for an axis, to run after the earlier jobs for it.
  /// @param place of the axis in BenchInfo::axes
  /// @return false if it is refused: too many are waiting (AxisJobs), or the bench has never been
  ///         there.
  [[nodiscard]] bool post(std::size_t place, AxisJobs::Kind kind, Job job);

  /// Sends set-points for the next tick, after earlier ones.
  void send(std::vector<client::SetPointFrame> frames);

  /// @return the number of frames dropped so far.
  [[nodiscard]] std::uint64_t dropped_frames() const;

  /// Reports the failure of a call to the bench, unless the bench was lost (BenchAdapter::on_lost)
  /// or the program is ending.
  void report(const client::Outcome& outcome, const std::string& subject,
              const std::string& what = "");

 private:
  using Clock = BenchFollower::Clock;
  using Axes = std::shared_ptr<const std::vector<client::Axis>>;

  struct WaitingJobs {
    AxisJobs jobs;
    bool is_posted = false;  ///< its worker has a job for it
  };

  void run(const std::stop_token& stop);
  [[nodiscard]] client::Result<BenchFollower::Next> begin();
  void follow();
  [[nodiscard]] std::optional<client::Observation> ask_again();
  void show(client::Observation&& observation);
  void send_waiting();
  void post_next(Worker& worker, std::size_t place);
  void work(Worker& worker, std::size_t place);

  BenchAdapter& adapter_;
  client::Session& session_;
  Reports& reports_;
  const std::uint32_t bench_;
  const std::vector<client::AxisId> ids_;
  const std::string label_;
  mutable std::mutex mutex_;  ///< guards the members up to `jobs_`
  Axes axes_;
  BoundedQueue<client::SetPointFrame> frames_{kMostWaitingFrames, WhenFull::drops_oldest};
  bool is_sending_ = false;
  std::vector<WaitingJobs> jobs_;  ///< by place
  // Used only by the thread that follows.
  BenchAdapter::State newest_;  ///< none while the bench is not there
  bool is_stepped_ = false;     ///< its bench is in lock-step
  Clock::time_point opened_{};
  Clock::time_point ask_due_{};  ///< for a state that the stream missed
  BenchFollower follower_;
  BenchControl control_;
  // Each axis is assigned to one worker: its jobs stay in order, and few axes wait for one another.
  std::deque<Worker> workers_;
  Worker sender_;
  std::jthread thread_;  ///< last: it uses all others
};

}  // namespace vdrive::bridge
