// SPDX-License-Identifier: Apache-2.0
#include "drive/interpolation.hpp"

#include "drive/frame.hpp"
#include "drive/limits.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "rounding.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace vdrive {
namespace {

using namespace vdrive::literals;

constexpr std::int64_t kLowestTimeIndex = -6;  // of 60C2h:02

/// The unit of 60C2h:01 [us] for each value of 60C2h:02, from the lowest to 0.
constexpr std::array<std::int64_t, 7> kInterpolationUnits{1,      10,      100,      1'000,
                                                          10'000, 100'000, 1'000'000};

static_assert(kObjectRows["interpolation_time_index"_object].lower_limit == kLowestTimeIndex &&
                  kObjectRows["interpolation_time_index"_object].upper_limit == 0 &&
                  static_cast<std::int64_t>(kInterpolationUnits.size()) == 1 - kLowestTimeIndex,
              "each value of 60C2h:02 has its unit");

/// @return 60C2h in ticks; both 0 and 1 mean the present tick.
std::uint32_t interpolation_ticks(const Drive& drive) {
  // A snapshot read from a file may hold any register value.
  const std::int64_t index =
      std::clamp<std::int64_t>(reg(drive, "interpolation_time_index"_object), kLowestTimeIndex, 0);
  const std::int64_t unit = kInterpolationUnits[static_cast<std::size_t>(index - kLowestTimeIndex)];
  return ticks_of_us(drive, unit * unsigned_reg(drive, "interpolation_time_period"_object));
}

/// @return the number of successive set-points that are missing; one is due every 60C2h.
std::uint32_t missing_set_points(const Drive& drive) {
  const Interpolation& way = drive.registers().interpolation;
  return way.silent_ticks / std::max<std::uint32_t>(way.period, 1);
}

/// The position demand while set-points are missing.
enum class Gap : std::uint8_t {
  none,          // it stays on the last set-point
  extrapolated,  // it continues at its velocity
  ended,         // it stays at the end of the extrapolation
};

Gap gap_of(const Drive& drive) {
  const std::int64_t most = reg(drive, "missing_set_points_extrapolated"_object);
  const std::uint32_t missing = missing_set_points(drive);
  if (most == 0 || missing == 0) return Gap::none;
  return missing <= most ? Gap::extrapolated : Gap::ended;
}

/// The position demand continued at its velocity, limited by 607Dh.
double extrapolated_position(const Drive& drive) {
  const double period = drive.timing().period_us * 1.0e-6;
  const double next = demand_position(drive) + demand_velocity(drive) * period;
  const double shown = shown_position(drive, next);
  return next + (within_software_limits(drive, shown) - shown);
}

double next_position(const Drive& drive, std::int32_t set_point) {
  switch (gap_of(drive)) {
    case Gap::extrapolated:
      return extrapolated_position(drive);
    case Gap::ended:
      return demand_position(drive);
    case Gap::none:
      break;
  }
  return interpolated_demand(drive, demand_position(drive), streamed_position(drive, set_point));
}

}  // namespace

void note_set_point(Drive& drive) {
  DriveState& s = drive.state();
  if (!operation_enabled(drive)) {
    end_stream(drive);
    return;
  }
  StreamState& stream = s.modes.stream;
  if (stream.stage == StreamStage::none) stream.stage = StreamStage::begins;
  stream.written = true;
  s.attention = true;
}

void end_stream(Drive& drive) {
  drive.state().modes.stream = {};
}

bool take_set_point(Drive& drive, std::int32_t set_point) {
  StreamState& stream = drive.state().modes.stream;
  Interpolation& way = drive.registers().interpolation;
  // An extrapolated demand has left the last set-point and must return if that is written again.
  const bool comes_back = stream.written && gap_of(drive) != Gap::none;
  if (stream.stage == StreamStage::begins || comes_back || set_point != way.set_point) {
    const std::uint32_t ticks = interpolation_ticks(drive);
    way.set_point = set_point;
    way.ticks_left = ticks;
    way.period = std::max<std::uint32_t>(ticks, 1);
    stream.stage = StreamStage::runs;
  }
  if (way.ticks_left != 0) --way.ticks_left;
  if (stream.written) {
    way.silent_ticks = 0;
  } else if (way.silent_ticks != kSaturatedCount) {
    ++way.silent_ticks;
  }
  stream.written = false;
  const std::int64_t fatal = reg(drive, "missing_set_points_until_fault"_object);
  if (fatal == 0 || missing_set_points(drive) < fatal) return true;
  raise_fault(drive, ErrorCode::sync_controller);
  return false;
}

double interpolated_demand(const Drive& drive, double start, double target) {
  const std::uint32_t ticks_left = drive.registers().interpolation.ticks_left;
  if (ticks_left == 0) return target;
  return start + (target - start) / (static_cast<double>(ticks_left) + 1.0);
}

double streamed_position(const Drive& drive, std::int32_t set_point) {
  const double goal = within_software_limits(drive, set_point);
  const double whole = nearest(demand_position(drive));
  const double way = drive.state().limits.enabled ? goal - shown_position(drive, whole)
                                                  : shorter_way(drive, goal - whole);
  return whole + way;
}

MotionRequest follow_position(const Drive& drive, std::int32_t set_point) {
  return {
      .kind = MotionRequest::Kind::follow,
      .target = next_position(drive, set_point),
      .limits = {
          .velocity = drive.registers().velocity_cap, .acceleration = 1.0, .deceleration = 1.0}};
}

bool follows_position(const Drive& drive, std::int32_t set_point) {
  const TargetState& target = drive.state().target;
  const DriveRegisters& registers = drive.registers();
  if (!drive.state().demand.following || gap_of(drive) != Gap::none) return false;
  const double wanted = set_point;
  if (registers.interpolation.ticks_left == 0) {
    return shown_position(drive, target.position) == shown_position(drive, wanted);
  }
  return target.position == registers.request.target &&
         within_software_limits(drive, wanted) == wanted;
}

}  // namespace vdrive
