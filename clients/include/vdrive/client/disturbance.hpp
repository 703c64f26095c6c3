// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/error_code.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::client {

/// A test-bench input (5E00h to 5E0Ch): an influence on an axis from outside.
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
  connection_loss,
  power_drop,
  frozen_feedback,
};

/// A disturbance: its name in the tool, the object that it writes, and its effect on the axis.
struct DisturbanceRow {
  Disturbance disturbance;
  std::string_view name;
  std::string_view variable_name;
  ErrorCode fault = ErrorCode::none;  ///< 603Fh of the fault that it causes
  std::string_view effect;            ///< when the fault occurs, or what the input does
};

/// Every disturbance, in the order of its objects.
inline constexpr std::array kDisturbances{
    DisturbanceRow{
        Disturbance::load_torque, "load_torque", "test_load_torque", ErrorCode::following_error,
        "a torque on the load; once the following error exceeds 6065h for longer than 6066h"},
    DisturbanceRow{Disturbance::blocked_load, "blocked_load", "test_blocked_load",
                   ErrorCode::following_error,
                   "holds the load; once the following error exceeds 6065h for longer than 6066h, "
                   "so never in a move shorter than 6065h"},
    DisturbanceRow{Disturbance::over_current, "over_current", "test_over_current",
                   ErrorCode::continuous_over_current, "immediately, in every state"},
    DisturbanceRow{Disturbance::over_temperature, "over_temperature", "test_over_temperature",
                   ErrorCode::excess_temperature_drive, "immediately, in every state"},
    DisturbanceRow{Disturbance::encoder_failure, "encoder_failure", "test_encoder_failure",
                   ErrorCode::incremental_sensor_1_fault,
                   "immediately, in every state; the axis coasts, regardless of 605Eh"},
    DisturbanceRow{
        Disturbance::dc_link_loss, "dc_link_loss", "test_dc_link_loss",
        ErrorCode::dc_link_under_voltage,
        "immediately if the motor has power; otherwise the axis changes to Switch on disabled"},
    DisturbanceRow{Disturbance::positive_limit, "positive_limit", "test_positive_limit_input",
                   ErrorCode::none, "stops a motion in positive direction; bit 1 of 60FDh"},
    DisturbanceRow{Disturbance::negative_limit, "negative_limit", "test_negative_limit_input",
                   ErrorCode::none, "stops a motion in negative direction; bit 0 of 60FDh"},
    DisturbanceRow{Disturbance::home_switch, "home_switch", "test_home_input", ErrorCode::none,
                   "the home switch for homing; bit 2 of 60FDh"},
    DisturbanceRow{Disturbance::index_pulse, "index_pulse", "test_index_pulse_input",
                   ErrorCode::none, "a rising edge is an index mark for homing"},
    DisturbanceRow{
        Disturbance::connection_loss, "connection_loss", "test_connection_loss",
        ErrorCode::life_guard_or_heartbeat,
        "a rising edge simulates the loss of the master: immediately in Operation enabled and "
        "Quick stop active if 6007h is 1; 0, 2 and 3 select another reaction"},
    DisturbanceRow{Disturbance::power_drop, "power_drop", "test_power_drop", ErrorCode::none,
                   "a rising edge changes Operation enabled to Switched on; the axis coasts until "
                   "a controlword enables it again"},
    DisturbanceRow{Disturbance::frozen_feedback, "frozen_feedback", "test_frozen_feedback",
                   ErrorCode::none,
                   "displayed positions freeze, velocities read 0; the control loop still has the "
                   "true feedback"},
};

/// @return a text such as "fault 2310h, continuous over-current: immediately, in every state".
[[nodiscard]] std::string text_of(const DisturbanceRow& row);

}  // namespace vdrive::client
