// SPDX-License-Identifier: Apache-2.0
#include "groups/line_times.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdrive::client {
namespace {

using std::chrono::microseconds;

constexpr double kMicrosecond = 1.0e-6;
// The range of the members of 5E10h.
constexpr microseconds kLongest{std::numeric_limits<std::uint32_t>::max()};
constexpr double kLongestWay = std::numeric_limits<std::uint32_t>::max();  // [UU]

/// Limits of the path parameter [1/s, 1/s²].
MotionLimits along_path(std::span<const AxisDistance> ways) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MotionLimits path{.velocity = kInfinity, .acceleration = kInfinity, .deceleration = kInfinity};
  for (const AxisDistance& way : ways) {
    if (way.distance == 0.0) continue;
    path.velocity = std::min(path.velocity, way.limits.velocity / way.distance);
    path.acceleration = std::min(path.acceleration, way.limits.acceleration / way.distance);
    path.deceleration = std::min(path.deceleration, way.limits.deceleration / way.distance);
  }
  return path;
}

/// Jerk of the path parameter [1/s³]; infinite if no axis limits it.
MotionJerk jerk_along_path(std::span<const AxisDistance> ways) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MotionJerk path{.acceleration = kInfinity, .deceleration = kInfinity};
  for (const AxisDistance& way : ways) {
    if (way.distance == 0.0 || !is_limited(way.jerk)) continue;
    path.acceleration = std::min(path.acceleration, way.jerk.acceleration / way.distance);
    path.deceleration = std::min(path.deceleration, way.jerk.deceleration / way.distance);
  }
  return path;
}

/// @return the jerk time [s]: how long the acceleration builds up, and equally how long it decays,
///         in each of the two ramps between rest and `peak`.
double jerk_time(double peak, const MotionLimits& path, const MotionJerk& jerk) {
  const auto of_ramp = [peak](double highest, double of_path) {
    return std::min(highest / of_path, std::sqrt(peak / of_path));
  };
  return std::max(of_ramp(path.acceleration, jerk.acceleration),
                  of_ramp(path.deceleration, jerk.deceleration));
}

/// @return the part of the path that the ramps to `peak` and back need.
double way_of_ramps(double peak, const MotionLimits& path, const MotionJerk& jerk) {
  const double grows = jerk_time(peak, path, jerk);
  const double up = std::max(peak / path.acceleration + grows, 2.0 * grows);
  const double down = std::max(peak / path.deceleration + grows, 2.0 * grows);
  return 0.5 * peak * (up + down);
}

/// @return whether the ramps to `peak` and back fit on the path.
bool ramps_fit(double peak, const MotionLimits& path, const MotionJerk& jerk) {
  return way_of_ramps(peak, path, jerk) <= 1.0;
}

/// @return the highest speed of the path parameter [1/s] whose ramps fit.
double highest_peak(const MotionLimits& path, const MotionJerk& jerk) {
  constexpr int kHalvings = 100;  // more than the bits of a double
  const double triangle = std::sqrt(2.0 * path.acceleration * path.deceleration /
                                    (path.acceleration + path.deceleration));
  const double peak = std::min(path.velocity, triangle);
  if (std::isinf(jerk.acceleration) || ramps_fit(peak, path, jerk)) return peak;
  double low = 0.0;
  double high = peak;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (ramps_fit(middle, path, jerk) ? low : high) = middle;
  }
  return low;
}

/// @return `seconds` in microseconds, rounded up to an integer of at least one. An integer stays
///         the same despite rounding errors in its last bits.
microseconds rounded_up(double seconds) {
  constexpr double kNoise = 1.0e-5;  // the error of a double in 4295 s of microseconds is less
  return microseconds{
      static_cast<std::int64_t>(std::max(1.0, std::ceil(seconds / kMicrosecond - kNoise)))};
}

}  // namespace

bool keeps_limits(const AxisDistance& way, const LineTimes& times) noexcept {
  // The same expressions as in the drive's own check, to the last bit.
  const MoveTimes seconds{
      .duration = static_cast<double>(times.duration.count()) * kMicrosecond,
      .acceleration = static_cast<double>(times.acceleration.count()) * kMicrosecond,
      .deceleration = static_cast<double>(times.deceleration.count()) * kMicrosecond,
      .jerk = static_cast<double>(times.jerk.count()) * kMicrosecond};
  const MotionLimits needed = limits_of(way.distance, seconds);
  const MotionJerk jerk = jerk_of(needed, seconds);
  const bool keeps_jerk = !is_limited(way.jerk) || (jerk.acceleration <= way.jerk.acceleration &&
                                                    jerk.deceleration <= way.jerk.deceleration);
  return needed.velocity <= way.limits.velocity && needed.acceleration <= way.limits.acceleration &&
         needed.deceleration <= way.limits.deceleration && keeps_jerk;
}

std::optional<LineTimes> plan_line(std::span<const AxisDistance> ways, microseconds period) {
  const bool any = std::ranges::any_of(ways, [](const AxisDistance& way) {
    return way.distance != 0.0;
  });
  if (!any) return LineTimes{};
  const MotionLimits path = along_path(ways);
  const MotionJerk jerk = jerk_along_path(ways);
  const double peak = highest_peak(path, jerk);
  // One second above the longest, so that the values rounded up below fit their type.
  if (!(1.0 / peak < static_cast<double>(kLongest.count()) * kMicrosecond + 1.0)) {
    return std::nullopt;
  }
  LineTimes times{.acceleration = rounded_up(peak / path.acceleration),
                  .deceleration = rounded_up(peak / path.deceleration)};
  if (!std::isinf(jerk.acceleration)) {
    times.jerk = rounded_up(jerk_time(peak, path, jerk));
    times.acceleration = std::max(times.acceleration + times.jerk, 2 * times.jerk);
    times.deceleration = std::max(times.deceleration + times.jerk, 2 * times.jerk);
  }
  const microseconds ramps = times.acceleration + times.deceleration;
  const double ramp_seconds = static_cast<double>(ramps.count()) * kMicrosecond;
  const microseconds shortest = std::max(ramps, rounded_up(0.5 * ramp_seconds + 1.0 / peak));
  times.duration = (shortest + period - microseconds{1}) / period * period;
  const auto kept = [&times](const AxisDistance& way) {
    return way.distance == 0.0 || keeps_limits(way, times);
  };
  while (times.duration <= kLongest && !std::ranges::all_of(ways, kept)) times.duration += period;
  if (times.duration > kLongest) return std::nullopt;
  return times;
}

std::optional<MovingTimes> plan_moving_line(std::span<const AxisDistance> ways) {
  // The duration only encodes the speed; no move takes exactly this long. So it is not rounded up
  // to whole ticks, which would only make the axes slower.
  constexpr microseconds kFinest{1};
  const MotionLimits path = along_path(ways);
  const double needed = way_of_ramps(path.velocity, path, jerk_along_path(ways));
  const double longest = std::ranges::max_element(ways, {}, &AxisDistance::distance)->distance;
  // One more than needed: rounding up makes the ramps longer.
  const double stretch =
      std::max(1.0, std::min(std::floor(needed) + 1.0, std::floor(kLongestWay / longest)));
  std::vector<AxisDistance> stretched(ways.begin(), ways.end());
  for (AxisDistance& way : stretched) way.distance *= stretch;
  const auto times = plan_line(stretched, kFinest);
  if (!times) return std::nullopt;
  return MovingTimes{.times = *times, .stretch = static_cast<std::uint32_t>(stretch)};
}

microseconds longest_duration(const LineTimes& times, double left, double speed) noexcept {
  constexpr double kForever = 1.0e9;  // [s]; also fits in nanoseconds
  const auto seconds = [](microseconds time) {
    return static_cast<double>(time.count()) * kMicrosecond;
  };
  const double ramps = seconds(times.acceleration + times.deceleration);
  const double peak = 1.0 / (seconds(times.duration) - 0.5 * ramps);
  // The speed may be above the peak and still grow for a while. In the worst case the axes stop,
  // which takes `stop`, and return from rest.
  const double ratio = 1.0 + speed / peak;
  const double stop = ratio * ramps;
  const double back = left + ratio * peak * stop;
  const double longest = std::min(stop + ramps + back / peak, kForever);
  return microseconds{static_cast<std::int64_t>(longest / kMicrosecond) + 1};
}

}  // namespace vdrive::client
