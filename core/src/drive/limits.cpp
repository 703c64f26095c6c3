// SPDX-License-Identifier: Apache-2.0
#include "drive/limits.hpp"

#include "drive/frame.hpp"
#include "drive/registers.hpp"
#include "torque_limit.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive {

using namespace vdrive::literals;

double within_software_limits(const Drive& drive, double target) {
  const LimitState& limits = drive.state().limits;
  return limits.enabled ? std::min(std::max(target, limits.lower), limits.upper) : target;
}

double within_torque_limits(const Drive& drive, double torque) {
  const UnitBlock& units = drive.block().units;
  const std::size_t l = drive.lane();
  const double highest = real(drive, "max_torque"_object);
  const double unit = std::min(units.torque_per_mille[l] / units.current_per_mille[l], 1.0);
  const auto limit = [&drive, highest, unit](ObjectRow row) {
    return torque_limit(highest, real(drive, row), unit);
  };
  return std::min(std::max(torque, -limit("negative_torque_limit_relative"_object)),
                  limit("positive_torque_limit_relative"_object));
}

bool at_limit_switch(const Drive& drive, double direction) {
  const std::uint8_t input = direction > 0.0 ? kPositiveLimitInput : kNegativeLimitInput;
  return (drive.state().limits.inputs & input) != 0;
}

bool runs_into_limit_switch(const Drive& drive, double motion) {
  return motion != 0.0 && at_limit_switch(drive, motion);
}

bool drifts_into_limit_switch(const Drive& drive) {
  const double speed = actual_velocity(drive);
  const auto threshold = static_cast<double>(drive.state().window.threshold);
  return std::abs(speed) > threshold && runs_into_limit_switch(drive, speed);
}

std::uint16_t bits_at_limits(const Drive& drive, double internal_demand, double internal_actual) {
  const LimitState& limits = drive.state().limits;
  unsigned bits = 0;
  if ((limits.inputs & (kNegativeLimitInput | kPositiveLimitInput)) != 0) {
    bits |= Statusword::kInternalLimitActive;
  }
  if (limits.enabled) {
    const double demand = shown_position(drive, internal_demand);
    const double actual = shown_position(drive, internal_actual);
    if (std::min(demand, actual) <= limits.lower || std::max(demand, actual) >= limits.upper) {
      bits |= Statusword::kInternalLimitActive;
    }
    if (actual < limits.lower || actual > limits.upper) bits |= Statusword::kWarning;
  }
  return static_cast<std::uint16_t>(bits);
}

}  // namespace vdrive
