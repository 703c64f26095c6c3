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

/// What a bridge makes of a bench that it follows. The thread of the link calls it, which is the
/// one that may wait for the bench. A final class with its link as its last member gets no call
/// before its other members are there, and none after they begin to go.
class BenchAdapter {
 public:
  /// Axes in the order of BenchInfo::axes.
  using State = std::shared_ptr<const client::Observation>;

  virtual ~BenchAdapter() = default;

  /// The bench is there, or is there again; its first state follows.
  virtual void on_open(const client::BenchInfo& /*info*/,
                       const std::vector<client::Axis>& /*axes*/) {}

  /// The bench has a newer state.
  virtual void on_state(const State& state) = 0;

  /// The bench is silent or has ended.
  virtual void on_lost() = 0;

  /// Before each look at the bench, which takes 10 ms at most: what the bridge wants of the link.
  virtual void before_turn(BenchLink& /*link*/) {}
};

/// The connection to a bench whose time others advance: threads follow its axes, keep control of
/// them, send set-points, and carry out jobs for axes. Every call that waits for the bench is made
/// there. The destructor waits for the call under way.
class BenchLink final {
 public:
  using Job = std::function<void(client::Axis& axis)>;

  /// Frames of set-points that may wait for the bench; the oldest beyond are dropped.
  static constexpr std::size_t kMostWaitingFrames = 1'024;

  /// @param adapter, session, reports outlive this
  BenchLink(BenchAdapter& adapter, client::Session& session, Reports& reports,
            const client::BenchInfo& info, BenchControl::Options control);
  ~BenchLink() = default;
  BenchLink(const BenchLink&) = delete;
  BenchLink& operator=(const BenchLink&) = delete;

  // Any thread; no call waits.

  /// Whether control of all axes is wanted from now on. Wanted once more after a loss, it is taken
  /// again.
  void want_control(bool wanted) { control_.want(wanted); }

  /// Has a job done with an axis, after the jobs for this axis before it.
  /// @param place of the axis in BenchInfo::axes
  /// @return false when it is refused: too many wait (AxisJobs), or the bench was never there.
  [[nodiscard]] bool post(std::size_t place, AxisJobs::Kind kind, Job job);

  /// Sends set-points after those before, for the next tick.
  void send(std::vector<client::SetPointFrame> frames);

  /// @return frames that were dropped, since it was made.
  [[nodiscard]] std::uint64_t dropped_frames() const;

  /// Reports what a call to the bench failed with. A bench that is lost is reported as such, and a
  /// program that ends reports nothing.
  void report(const client::Outcome& outcome, const std::string& subject,
              const std::string& what = "");

 private:
  using Clock = BenchFollower::Clock;
  using Axes = std::shared_ptr<const std::vector<client::Axis>>;

  /// What waits for an axis.
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
  mutable std::mutex mutex_;  ///< guards what follows
  Axes axes_;
  BoundedQueue<client::SetPointFrame> frames_{kMostWaitingFrames, WhenFull::drops_oldest};
  bool is_sending_ = false;
  std::vector<WaitingJobs> jobs_;  ///< by place
  // Of the thread that follows.
  BenchAdapter::State newest_;  ///< none while the bench is not there
  bool is_stepped_ = false;     ///< its bench is in lock-step
  Clock::time_point opened_{};
  Clock::time_point ask_due_{};  ///< for a state that the stream did not show
  BenchFollower follower_;
  BenchControl control_;
  // Each axis has its worker: its jobs are in order, and few axes wait for another one.
  std::deque<Worker> workers_;
  Worker sender_;
  std::jthread thread_;  ///< last: it uses all others
};

}  // namespace vdrive::bridge
