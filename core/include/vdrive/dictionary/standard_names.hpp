// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <array>
#include <optional>
#include <string_view>

namespace vdrive {

/// The CiA 402-2 name of an object that has another name in the manual. Users may write either.
struct StandardName {
  std::string_view name;
  std::string_view variable_name;
};

inline constexpr std::array kStandardNames{
    StandardName{"controlword", "ds402_controlword"},
    StandardName{"statusword", "ds402_statusword"},
    StandardName{"modes_of_operation", "op_mode_cmd"},
    StandardName{"modes_of_operation_display", "op_mode_actual"},
    StandardName{"position_actual_value", "load_position_actual_value"},
    StandardName{"velocity_actual_value", "load_velocity_actual_value"},
    StandardName{"following_error_actual_value", "load_position_error_value"},
    StandardName{"target_position", "position_user_target_value"},
    StandardName{"position_window", "position_target_reached_window"},
    StandardName{"position_window_time", "position_target_reached_window_time"},
    StandardName{"min_position_limit", "user_position_lower_limit"},
    StandardName{"max_position_limit", "user_position_upper_limit"},
    StandardName{"max_profile_velocity", "app_speed_limit"},
    StandardName{"max_motor_speed", "motor_max_speed_rpm"},
    StandardName{"torque_demand_value", "torque_demand"},
    StandardName{"speed_during_search_for_switch", "homing_speed_search"},
    StandardName{"speed_during_search_for_zero", "homing_speed_creep"},
    StandardName{"profile_acceleration", "profile_acc"},
    StandardName{"profile_deceleration", "profile_dec"},
    StandardName{"touch_probe_1_positive_edge", "touch_probe_position_1_positive_value"},
    StandardName{"touch_probe_1_negative_edge", "touch_probe_position_1_negative_value"},
    StandardName{"touch_probe_2_positive_edge", "touch_probe_position_2_positive_value"},
    StandardName{"touch_probe_2_negative_edge", "touch_probe_position_2_negative_value"},
    StandardName{"touch_probe_1_source", "touch_probe_source_1"},
    StandardName{"touch_probe_2_source", "touch_probe_source_2"},
    StandardName{"interpolation_time_period_value", "interpolation_time_period"},
    StandardName{"buffer_organization", "interpolation_buffer_organization"},
    StandardName{"buffer_clear", "interpolation_buffer_clear"},
    StandardName{"physical_outputs", "digital_outputs"},
    StandardName{"bit_mask", "digital_outputs_mask"},
    StandardName{"max_acceleration", "app_acc_limit"},
    StandardName{"max_deceleration", "app_dec_limit"},
    StandardName{"positive_torque_limit_value", "positive_torque_limit_relative"},
    StandardName{"negative_torque_limit_value", "negative_torque_limit_relative"},
};

/// @param name a variable_name or the standard's name
/// @return the row of that object, or nothing.
[[nodiscard]] std::optional<ObjectRow> find_named(std::string_view name) noexcept;

}  // namespace vdrive
