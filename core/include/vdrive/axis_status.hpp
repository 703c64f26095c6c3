// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>

namespace vdrive {

/// Status image of one axis after one tick: every monitored object of the manual under its
/// variable_name, and further members for observers. Plain data, written once per tick.
struct AxisStatus {
  std::int32_t position_demand_value = 0;        ///< 6062h [user units]
  std::int32_t load_position_actual_value = 0;   ///< 6064h [user units]
  std::int32_t load_position_error_value = 0;    ///< 60F4h [user units]
  std::int32_t motor_position_actual_value = 0;  ///< 3572h [user units]
  std::int32_t motor_position_error_value = 0;   ///< 3573h [user units]
  std::int32_t velocity_demand_value = 0;        ///< 606Bh [user units/s]
  std::int32_t load_velocity_actual_value = 0;   ///< 606Ch [user units/s]
  std::int32_t load_velocity_error_value = 0;    ///< 351Eh [user units/s]
  std::int32_t motor_velocity_actual_value = 0;  ///< 3574h [user units/s]
  std::int32_t motor_velocity_error_value = 0;   ///< 3575h [user units/s]
  std::int32_t current_error_value = 0;          ///< 351Fh [mA]
  std::int16_t current_actual_value = 0;         ///< 6078h [‰ of rated current]
  std::int16_t torque_actual_value = 0;          ///< 6077h [‰ of rated torque]
  std::int16_t torque_demand = 0;                ///< 6074h [‰ of rated torque]
  std::uint16_t ds402_statusword = 0;            ///< 6041h
  std::uint16_t ds402_controlword = 0;           ///< 6040h in force; not on the wire
  std::uint16_t error_code = 0;                  ///< 603Fh
  std::int8_t op_mode_actual = 0;                ///< 6061h
  std::uint8_t motor_op_status = 0;              ///< 3005h, 0 = disabled, 1 = enabled
  std::uint8_t error_register = 0;               ///< 1001h
  std::uint8_t digital_inputs = 0;               ///< 60FDh, bits 0 to 2
  std::uint32_t ignored_set_points = 0;  ///< rising edges of bit 4 not accepted since power-up
  std::uint32_t fault_count = 0;         ///< faults since power-up
};

/// A member of AxisStatus with its name.
template <typename Number>
struct StatusField {
  std::string_view name;
  Number AxisStatus::*member;
  bool is_published = true;  ///< whether the status on the network contains it, under the same name
};

template <typename Number, typename... Published>
StatusField(const char*, Number AxisStatus::*, Published...) -> StatusField<Number>;

/// Every member of AxisStatus once, in order of declaration, which is also the order of the check
/// values in a journal.
inline constexpr std::tuple kStatusFields{
    StatusField{"position_demand_value", &AxisStatus::position_demand_value},
    StatusField{"load_position_actual_value", &AxisStatus::load_position_actual_value},
    StatusField{"load_position_error_value", &AxisStatus::load_position_error_value},
    StatusField{"motor_position_actual_value", &AxisStatus::motor_position_actual_value},
    StatusField{"motor_position_error_value", &AxisStatus::motor_position_error_value},
    StatusField{"velocity_demand_value", &AxisStatus::velocity_demand_value},
    StatusField{"load_velocity_actual_value", &AxisStatus::load_velocity_actual_value},
    StatusField{"load_velocity_error_value", &AxisStatus::load_velocity_error_value},
    StatusField{"motor_velocity_actual_value", &AxisStatus::motor_velocity_actual_value},
    StatusField{"motor_velocity_error_value", &AxisStatus::motor_velocity_error_value},
    StatusField{"current_error_value", &AxisStatus::current_error_value},
    StatusField{"current_actual_value", &AxisStatus::current_actual_value},
    StatusField{"torque_actual_value", &AxisStatus::torque_actual_value},
    StatusField{"torque_demand", &AxisStatus::torque_demand},
    StatusField{"ds402_statusword", &AxisStatus::ds402_statusword},
    StatusField{"ds402_controlword", &AxisStatus::ds402_controlword, false},
    StatusField{"error_code", &AxisStatus::error_code},
    StatusField{"op_mode_actual", &AxisStatus::op_mode_actual},
    StatusField{"motor_op_status", &AxisStatus::motor_op_status},
    StatusField{"error_register", &AxisStatus::error_register},
    StatusField{"digital_inputs", &AxisStatus::digital_inputs},
    StatusField{"ignored_set_points", &AxisStatus::ignored_set_points},
    StatusField{"fault_count", &AxisStatus::fault_count}};

inline constexpr std::size_t kStatusMembers = std::tuple_size_v<decltype(kStatusFields)>;

/// One member of AxisStatus. The digest, the replay of journals and the clients use this table.
struct StatusMember {
  std::string_view name;
  ObjectAddress address;                     ///< of the object that it shows; index 0 = none
  DataType data_type = DataType::integer32;  ///< of the member
  bool is_published = false;                 ///< whether the status on the network contains it
  std::int64_t (*value)(const AxisStatus& status) noexcept = nullptr;
  /// Sets the member, which can hold every value that its object takes; a `value` beyond the range
  /// of the member is truncated.
  void (*set)(AxisStatus& status, std::int64_t value) noexcept = nullptr;
};

/// The members of AxisStatus in order of declaration.
[[nodiscard]] std::span<const StatusMember, kStatusMembers> status_members() noexcept;

/// @return the value of object `row` in the status image, or nothing when no published member shows
///         it.
[[nodiscard]] std::optional<std::int64_t> value_of(const AxisStatus& status,
                                                   ObjectRow row) noexcept;

}  // namespace vdrive
