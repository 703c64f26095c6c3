// SPDX-License-Identifier: Apache-2.0
#include "drive/stops.hpp"

#include "drive/registers.hpp"

#include <algorithm>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// Value of a ramp object, limited by 60C5h or 60C6h; 0 counts as 1.
double within(const Drive& drive, ObjectRow ramp, ObjectRow cap) {
  return std::min(std::max(real(drive, ramp), 1.0), std::max(real(drive, cap), 1.0));
}

}  // namespace

double acceleration_of(const Drive& drive, ObjectRow row) {
  return within(drive, row, "app_acc_limit"_object);
}

double deceleration_of(const Drive& drive, ObjectRow row) {
  return within(drive, row, "app_dec_limit"_object);
}

MotionJerk profile_jerk(const Drive& drive) {
  constexpr std::int64_t kLimitedJerk = 3;
  if (reg(drive, "motion_profile_type"_object) != kLimitedJerk) return {};
  // A snapshot read from a file may hold any register value.
  const double first = std::max(real(drive, "profile_jerk_1"_object), 1.0);
  const double second = std::max(real(drive, "profile_jerk_2"_object), 1.0);
  const bool has_two = reg(drive, "profile_jerk_use"_object) == 2;
  return {.acceleration = first, .deceleration = has_two ? second : first};
}

MotionRequest stop_with(double deceleration) {
  return {.kind = MotionRequest::Kind::stop,
          .limits = {.velocity = 0.0, .acceleration = 1.0, .deceleration = deceleration}};
}

MotionRequest ramp_stop(const Drive& drive, ObjectRow row) {
  return stop_with(deceleration_of(drive, row));
}

MotionRequest profile_stop(const Drive& drive, ObjectRow row) {
  MotionRequest request = ramp_stop(drive, row);
  request.jerk = profile_jerk(drive);
  return request;
}

MotionRequest torque_to(const Drive& drive, double target) {
  return {.kind = MotionRequest::Kind::torque,
          .control = ControlLoop::torque,
          .target = target,
          .limits = {.velocity = 0.0,
                     .acceleration = std::max(real(drive, "torque_slope"_object), 1.0),
                     .deceleration = 1.0}};
}

MotionRequest release_torque(const Drive& drive) {
  return torque_to(drive, 0.0);
}

MotionRequest limit_switch_stop(const Drive& drive) {
  return ramp_stop(drive, "quick_stop_deceleration"_object);
}

double option_deceleration(const Drive& drive, std::int64_t option, double normal) {
  switch (option) {
    case 1:
      return normal;
    case 2:
      return deceleration_of(drive, "quick_stop_deceleration"_object);
    default:
      return deceleration_of(drive, "app_dec_limit"_object);
  }
}

MotionRequest stop_by_option(const Drive& drive, std::int64_t option, const MotionRequest& normal) {
  return option == 1 ? normal : stop_with(option_deceleration(drive, option, 0.0));
}

}  // namespace vdrive
