// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_follower.hpp"
#include "bridge/drive_jobs.hpp"
#include "bridge/node_control.hpp"
#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "reports.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "worker.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::canopen {

/// The connection to a bench whose time others advance: threads follow its axes, keep control of
/// them, send set-points, and carry out what nodes ask of their drives. Every call that waits for
/// the bench is made there. The destructor waits for the call under way.
class BenchLink {
 public:
  /// The axes after a tick.
  struct State {
    client::Observation observation;
    DriveTime time{};
  };

  /// What became of the bench since the last question.
  struct News {
    bool was_lost = false;                  ///< first: what is newest is that of a new beginning
    std::shared_ptr<const State> newest{};  ///< none = nothing came
  };

  /// Frames of set-points that may wait for the bench; the oldest beyond are dropped.
  static constexpr std::size_t kMostWaitingFrames = 1'024;

  /// @param session, reports outlive this
  /// @param notify called by a thread of the link when there are news and the last ones were taken
  BenchLink(client::Session& session, const client::BenchInfo& info, std::string label,
            bridge::Reports& reports, std::function<void()> notify);
  ~BenchLink() = default;
  BenchLink(const BenchLink&) = delete;
  BenchLink& operator=(const BenchLink&) = delete;

  /// Any thread, as all that follow; none of them waits.
  [[nodiscard]] News take_news();

  /// @param done called with the answer, by a thread of the link or at once
  void access(std::size_t place, const DriveAccess& access,
              const std::function<void(const DriveAnswer&)>& done);

  /// Reads objects, behind what the axis was asked for before.
  /// @param done likewise, with the values that could be read
  void read(std::size_t place, std::vector<ObjectAddress> objects,
            const std::function<void(const std::vector<DriveValue>&)>& done);
  void tell_connection(std::size_t place, bool is_lost);
  void cycle_power(std::size_t place);

  /// For the next tick, in order, behind those before.
  void send(std::vector<client::SetPointFrame> frames);

  /// @return frames that were dropped, since it was made.
  [[nodiscard]] std::uint64_t dropped_frames() const;

 private:
  using Axes = std::shared_ptr<const std::vector<client::Axis>>;

  /// What waits for the drive of an axis.
  struct WaitingJobs {
    DriveJobs jobs;
    bool is_posted = false;  ///< its worker has a job for it
  };

  void run(const std::stop_token& stop);
  [[nodiscard]] client::Result<bridge::BenchFollower::Next> begin();
  void follow();
  [[nodiscard]] std::optional<client::Observation> ask_again();
  void show(client::Observation&& observation);
  void tell(News news);
  void send_waiting();
  [[nodiscard]] bool post(std::size_t place, DriveJobs::Kind kind,
                          std::function<void(client::Axis& axis)> job);
  void post_next(std::size_t place);
  void work(std::size_t place);
  void report_failure(const client::Outcome& outcome, std::size_t place);

  client::Session& session_;
  const std::uint32_t bench_;
  const std::vector<client::AxisId> ids_;
  const std::string label_;
  bridge::Reports& reports_;
  const std::function<void()> notify_;
  mutable std::mutex mutex_;  ///< guards what follows
  Axes axes_;
  News news_;
  bool are_news_ = false;  ///< notify_ was called for them
  std::vector<client::SetPointFrame> waiting_;
  bool is_sending_ = false;
  std::uint64_t dropped_frames_ = 0;
  std::vector<WaitingJobs> jobs_;  ///< by place
  // Of the thread that follows.
  std::chrono::microseconds period_;
  bool is_stepped_ = false;  ///< its bench is in lock-step
  bridge::BenchFollower::Clock::time_point opened_{};
  bridge::BenchFollower::Clock::time_point ask_due_{};
  std::uint64_t shown_tick_ = 0;
  bridge::BenchFollower follower_;
  NodeControl control_;
  // Each axis has its worker: its accesses are in order, and few axes wait for another one.
  std::array<bridge::Worker, 8> workers_;
  bridge::Worker sender_;
  std::jthread thread_;  ///< last: it uses all others
};

}  // namespace vdrive::canopen
