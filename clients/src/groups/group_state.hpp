// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calls/axes_command.hpp"
#include "groups/line_course.hpp"
#include "groups/line_times.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

namespace vdrive::client {

/// A straight line that was requested.
struct LineRequest {
  std::vector<std::int32_t> targets;
  double velocity_factor = 1.0;
  double acceleration_factor = 1.0;
  double deceleration_factor = 1.0;
};

/// A straight line that has been handed to the axes.
struct LineInHand {
  std::vector<std::int32_t> starts;
  std::vector<std::int32_t> targets;
  std::chrono::microseconds duration{0};  ///< at most, where the line started in motion
  std::uint64_t start_tick = 0;           ///< in which the set-points are in force
  LineCourse course;
  std::vector<GivenCommand> given;  ///< the set-points
};

/// What the axes get with their targets.
struct LinePlan {
  LineTimes times;
  std::vector<std::int64_t> reference_ways;  ///< 5E10h:05 [UU]; each 0 from rest
  std::chrono::microseconds duration{0};     ///< at most, where the line starts in motion
  LineCourse course;
};

/// What is streamed: its mode, and the object that takes it.
struct StreamedRow {
  Streamed what;
  OperatingMode mode;
  ObjectRow object;
  std::string_view noun;  ///< of one set-point
};

/// In the order of Streamed.
inline constexpr std::array kStreamedRows = [] {
  using namespace vdrive::literals;
  return std::array{
      StreamedRow{Streamed::positions, OperatingMode::cyclic_synchronous_position,
                  "position_user_target_value"_object, "position"},
      StreamedRow{Streamed::velocities, OperatingMode::cyclic_synchronous_velocity,
                  "target_velocity"_object, "velocity"},
      StreamedRow{Streamed::torques, OperatingMode::cyclic_synchronous_torque,
                  "target_torque"_object, "torque"},
  };
}();

/// Set-points on their way in cyclic streaming.
struct Stream {
  const StreamedRow& row;
  StreamOptions options;
  AxesCall call;
  std::deque<std::vector<SentFrames>> in_flight;  ///< real time: oldest first
  std::uint64_t next_tick = 0;          ///< real time: of the next set-point; 0 = none yet
  std::vector<std::size_t> released{};  ///< places of the axes that have kReleaseStream
};

/// What copies of a group share.
struct AxisGroup::State {
  std::shared_ptr<SessionCore> core;
  GroupLayout layout;

  std::mutex mutex;  ///< guards what follows up to the stream
  std::optional<LineInHand> line;
  std::deque<LineRequest> queue;

  std::unique_ptr<Stream> stream;
  std::jthread monitor;

  /// @return the outcome of a call that has ended: with the session that has taken an axis, where
  ///         one has.
  [[nodiscard]] Outcome explained(Outcome outcome) const;

  /// A call that reports its progress to `options`.
  AxesCall call(const GroupCallOptions& options);
  ObservedAxes::Progress progress_of(const GroupCallOptions& options);

  /// The steps of EachCommand::resume after its begin().
  Outcome resume(AxesCommand& resume, const GroupCallOptions& options);

  /// Vectors of the caller as whole set-points, each within its object.
  Result<std::vector<std::int32_t>> set_points_of(const Eigen::VectorXd& values,
                                                  const StreamedRow& row) const;
  Result<LineRequest> request_of(const Eigen::VectorXd& targets,
                                 const GroupMoveOptions& options) const;

  /// Hands a line to the axes, from rest or along the line in hand; no time passes in lock-step
  /// unless an axis comes from another mode, or moving axes have to be halted again. The line in
  /// hand stays when it is refused before anything is in force.
  Outcome start(AxesCall& call, const LineRequest& request);

  /// @return whether the demands have come to rest on their targets.
  [[nodiscard]] static bool has_arrived(const LineInHand& line, std::span<const AxisSnapshot> axes);

  /// Waits until the line in hand has arrived: the demands, and when `in_position` the axes too.
  Outcome await_line(AxesCall& call, const GroupCallOptions& options, bool in_position);

  /// Starts `request` and waits as long as the options require.
  Outcome run(AxesCall& call, const LineRequest& request, const GroupCallOptions& options);

  [[nodiscard]] std::optional<LineInHand> line_in_hand();
  void set_line(std::optional<LineInHand> started);
  std::optional<LineRequest> next_request();
  void drop_queue();

  /// Nothing is left to do: after a stop or a failure.
  void drop_all();

  [[nodiscard]] GroupStatus status_of(const AxesCall& call);

  /// One turn of poll().
  Outcome watch(AxesCall& call);

  /// Stops the other axes when an axis of the line in hand has got another command.
  Outcome watch_commands(AxesCall& call);
  void monitor_loop(const std::stop_token& stop, AxesCall& call);

  /// What stream() does in lock-step and in real time.
  Outcome stream_stepping(const Round& round) const;
  Outcome stream_ahead(const Round& round) const;
  Outcome collect_oldest() const;
  void collect_rest() const;

 private:
  /// @return what the axes may do on their ways to the targets from where they are; the distances
  ///         are for a line from rest.
  Result<std::vector<AxisWay>> ways_of(AxesCall& call, const LineRequest& request,
                                       bool in_motion) const;
  [[nodiscard]] Outcome takes_too_long(std::span<const AxisWay> ways) const;
  Result<LinePlan> plan_from_rest(AxesCall& call, const LineRequest& request) const;
  Result<LinePlan> plan_in_motion(AxesCall& call, const LineRequest& request);
  static void withdraw(AxesCall& call);
};

/// @return a round that sets the mode of every axis, or of none.
[[nodiscard]] Round mode_round(const AxesCall& call, OperatingMode mode);

/// @return the time-out of a call that is no move.
[[nodiscard]] std::chrono::nanoseconds timeout_of(const GroupCallOptions& options);

}  // namespace vdrive::client
