// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace vdrive::client {

/// A test-bench input (5E00h to 5E09h): what acts on an axis from outside.
enum class Disturbance : std::uint8_t {
  load_torque,  ///< [mN.m]; the others are 1 = on, 0 = off
  blocked_load,
  over_current,
  over_temperature,
  encoder_failure,
  dc_link_loss,
  positive_limit,
  negative_limit,
  home_switch,
  index_pulse,
};

/// A disturbance, its word in the tool and the object that it writes.
struct DisturbanceRow {
  Disturbance disturbance;
  std::string_view name;
  std::string_view variable_name;
};

/// Every disturbance, in the order of its objects.
inline constexpr std::array kDisturbances{
    DisturbanceRow{Disturbance::load_torque, "load_torque", "test_load_torque"},
    DisturbanceRow{Disturbance::blocked_load, "blocked_load", "test_blocked_load"},
    DisturbanceRow{Disturbance::over_current, "over_current", "test_over_current"},
    DisturbanceRow{Disturbance::over_temperature, "over_temperature", "test_over_temperature"},
    DisturbanceRow{Disturbance::encoder_failure, "encoder_failure", "test_encoder_failure"},
    DisturbanceRow{Disturbance::dc_link_loss, "dc_link_loss", "test_dc_link_loss"},
    DisturbanceRow{Disturbance::positive_limit, "positive_limit", "test_positive_limit_input"},
    DisturbanceRow{Disturbance::negative_limit, "negative_limit", "test_negative_limit_input"},
    DisturbanceRow{Disturbance::home_switch, "home_switch", "test_home_input"},
    DisturbanceRow{Disturbance::index_pulse, "index_pulse", "test_index_pulse_input"},
};

}  // namespace vdrive::client
