// SPDX-License-Identifier: Apache-2.0
#include "groups/line_times.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vdrive::client {
namespace {

using std::chrono::microseconds;

constexpr double kMicrosecond = 1.0e-6;
// What 5E10h holds.
constexpr microseconds kLongest{std::numeric_limits<std::uint32_t>::max()};

/// Limits of the path parameter [1/s, 1/s²].
MotionLimits along_path(std::span<const AxisWay> ways) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MotionLimits path{.velocity = kInfinity, .acceleration = kInfinity, .deceleration = kInfinity};
  for (const AxisWay& way : ways) {
    if (way.distance == 0.0) continue;
    path.velocity = std::min(path.velocity, way.limits.velocity / way.distance);
    path.acceleration = std::min(path.acceleration, way.limits.acceleration / way.distance);
    path.deceleration = std::min(path.deceleration, way.limits.deceleration / way.distance);
  }
  return path;
}

/// @return `seconds` in whole microseconds, rounded up, at least one. A whole number stays one in
///         spite of its last bits.
microseconds rounded_up(double seconds) {
  constexpr double kNoise = 1.0e-5;  // in 4295 s of microseconds a double errs by less
  return microseconds{
      static_cast<std::int64_t>(std::max(1.0, std::ceil(seconds / kMicrosecond - kNoise)))};
}

}  // namespace

bool keeps_limits(const AxisWay& way, const LineTimes& times) noexcept {
  // The same expressions as the drive's own check, to the last bit.
  const MotionLimits needed =
      limits_of(way.distance,
                {.duration = static_cast<double>(times.duration.count()) * kMicrosecond,
                 .acceleration = static_cast<double>(times.acceleration.count()) * kMicrosecond,
                 .deceleration = static_cast<double>(times.deceleration.count()) * kMicrosecond});
  return needed.velocity <= way.limits.velocity && needed.acceleration <= way.limits.acceleration &&
         needed.deceleration <= way.limits.deceleration;
}

std::optional<LineTimes> plan_line(std::span<const AxisWay> ways, microseconds period) {
  const bool any = std::ranges::any_of(ways, [](const AxisWay& way) {
    return way.distance != 0.0;
  });
  if (!any) return LineTimes{};
  const MotionLimits path = along_path(ways);
  const double triangle = std::sqrt(2.0 * path.acceleration * path.deceleration /
                                    (path.acceleration + path.deceleration));
  const double peak = std::min(path.velocity, triangle);
  // One second more than the longest, so that what is rounded up below fits its type.
  if (!(1.0 / peak < static_cast<double>(kLongest.count()) * kMicrosecond + 1.0)) {
    return std::nullopt;
  }
  LineTimes times{.acceleration = rounded_up(peak / path.acceleration),
                  .deceleration = rounded_up(peak / path.deceleration)};
  const microseconds ramps = times.acceleration + times.deceleration;
  const double ramp_seconds = static_cast<double>(ramps.count()) * kMicrosecond;
  const microseconds shortest = std::max(ramps, rounded_up(0.5 * ramp_seconds + 1.0 / peak));
  times.duration = (shortest + period - microseconds{1}) / period * period;
  const auto kept = [&times](const AxisWay& way) {
    return way.distance == 0.0 || keeps_limits(way, times);
  };
  while (times.duration <= kLongest && !std::ranges::all_of(ways, kept)) times.duration += period;
  if (times.duration > kLongest) return std::nullopt;
  return times;
}

}  // namespace vdrive::client
