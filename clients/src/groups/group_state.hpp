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

/// A straight line as requested.
struct LineRequest {
  std::vector<std::int32_t> targets;
  double velocity_factor = 1.0;
  double acceleration_factor = 1.0;
  double deceleration_factor = 1.0;
};

/// A straight line that has been handed over to the axes.
struct ActiveLine {
  std::vector<std::int32_t> starts;
  std::vector<std::int32_t> targets;
  std::chrono::microseconds duration{0};  ///< an upper bound if the line started in motion
  std::uint64_t start_tick = 0;           ///< in which the set-points take effect
  LineCourse course;
  std::vector<GivenCommand> given;  ///< the set-points
};

/// The values sent to the axes with their targets, and the course that results.
struct LinePlan {
  LineTimes times;
  std::vector<std::int64_t> reference_ways;  ///< 5E10h:05 [UU]; all 0 if the line starts from rest
  std::chrono::microseconds duration{0};     ///< an upper bound if the line starts in motion
  LineCourse course;
};

/// A kind of stream: its mode, and the object that takes the set-points.
struct StreamedRow {
  Streamed what;
  OperatingMode mode;
  ObjectRow object;
  std::string_view noun;  ///< name of one set-point
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

/// The state of cyclic streaming.
struct Stream {
  const StreamedRow& row;
  StreamOptions options;
  AxesCall call;
  std::deque<std::vector<SentFrames>> in_flight;  ///< real time: oldest first
  std::uint64_t next_tick = 0;          ///< real time: of the next set-point; 0 = none yet
  std::vector<std::size_t> released{};  ///< places of the axes that got kReleaseStream
};

/// The state shared by the copies of a group.
struct AxisGroup::State {
  std::shared_ptr<SessionCore> core;
  GroupLayout layout;

  std::mutex mutex;  ///< guards `line` and `queue`
  std::optional<ActiveLine> line;
  std::deque<LineRequest> queue;

  std::unique_ptr<Stream> stream;
  std::jthread monitor;

  /// @return the outcome of a call that has ended, naming the session that has taken an axis, if
  ///         any.
  [[nodiscard]] Outcome explained(Outcome outcome) const;

  /// Creates a call that reports its progress to `options`.
  AxesCall call(const GroupCallOptions& options);
  ObservedAxes::Progress progress_of(const GroupCallOptions& options);

  /// The steps of EachCommand::resume after its begin().
  Outcome resume(AxesCommand& resume, const GroupCallOptions& options);

  /// Converts vectors of the caller to integer set-points, each within the range of its object.
  Result<std::vector<std::int32_t>> set_points_of(const Eigen::VectorXd& values,
                                                  const StreamedRow& row) const;
  Result<LineRequest> request_of(const Eigen::VectorXd& targets,
                                 const GroupMoveOptions& options) const;

  /// Hands a line over to the axes, from rest or along the present line. In lock-step no time
  /// passes, unless an axis has to change its mode or moving axes have to be halted again. The
  /// present line stays valid if this is refused before anything has taken effect.
  Outcome start(AxesCall& call, const LineRequest& request);

  /// @return whether the demand positions are at rest on their targets.
  [[nodiscard]] static bool has_arrived(const ActiveLine& line, std::span<const AxisSnapshot> axes);

  /// Waits until the demand positions have reached the end of the present line and, with
  /// `in_position`, the axes too.
  Outcome await_line(AxesCall& call, const GroupCallOptions& options, bool in_position);

  /// Starts `request`, then waits as the options require.
  Outcome run(AxesCall& call, const LineRequest& request, const GroupCallOptions& options);

  [[nodiscard]] std::optional<ActiveLine> active_line();
  void set_line(std::optional<ActiveLine> started);
  std::optional<LineRequest> next_request();
  void drop_queue();

  /// Clears line and queue after a stop or a failure.
  void drop_all();

  [[nodiscard]] GroupStatus status_of(const AxesCall& call);

  /// The checks that poll() and monitor() share.
  Outcome watch(AxesCall& call);

  /// Stops the other axes if an axis of the present line has got another command.
  Outcome watch_commands(AxesCall& call);
  void monitor_loop(const std::stop_token& stop, AxesCall& call);

  /// stream() in lock-step and in real time.
  Outcome stream_stepping(const Round& round) const;
  Outcome stream_ahead(const Round& round) const;
  Outcome collect_oldest() const;
  void collect_rest() const;

 private:
  /// @return the distances of the axes from their present positions to the targets, as for a line
  ///         from rest, and their limits.
  Result<std::vector<AxisDistance>> ways_of(AxesCall& call, const LineRequest& request,
                                            bool in_motion) const;
  [[nodiscard]] Outcome takes_too_long(std::span<const AxisDistance> ways) const;
  Result<LinePlan> plan_from_rest(AxesCall& call, const LineRequest& request) const;
  Result<LinePlan> plan_in_motion(AxesCall& call, const LineRequest& request);
  static void withdraw(AxesCall& call);
};

/// @return a round that sets the mode of every axis; if one axis of a bench refuses it, no axis of
///         that bench gets it.
[[nodiscard]] Round mode_round(const AxesCall& call, OperatingMode mode);

/// @return the time-out of a call that is not a move.
[[nodiscard]] std::chrono::nanoseconds timeout_of(const GroupCallOptions& options);

}  // namespace vdrive::client
