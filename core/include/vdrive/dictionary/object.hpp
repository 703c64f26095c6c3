// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

namespace vdrive {

/// Data types of CiA 301 that the dictionary uses (UNSn of the manual is UNSIGNEDn).
enum class DataType : std::uint8_t {
  integer8,
  integer16,
  integer32,
  unsigned8,
  unsigned16,
  unsigned32,
};

enum class Access : std::uint8_t { read_only, read_write };

/// Whether 1010h saves the object (column StoreInFlash).
enum class Storage : std::uint8_t { not_stored, flash };

/// When an accepted write takes effect on the drive. The manual marks every writable object
/// "immediately"; where its notes are more specific (607Fh, 6081h), the notes count.
enum class Effective : std::uint8_t {
  read_only,     ///< never written
  immediately,   ///< in the tick in which the write takes effect
  at_set_point,  ///< latched with the rising edge of controlword bit 4; in modes 7 to 10 with a
                 ///< new set-point
  at_enable,     ///< with the next transition 4
};

/// Where the description of a row comes from.
enum class Origin : std::uint8_t { manual, companion };

/// Address of an object as in CiA 301.
struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;

  friend constexpr bool operator==(const ObjectAddress&, const ObjectAddress&) = default;
  friend constexpr auto operator<=>(const ObjectAddress&, const ObjectAddress&) = default;
};

/// Position of an object in the dictionary; rows are sorted by index, then sub-index.
using ObjectRow = std::uint16_t;

/// The meaning of a write for control of the axis.
enum class Role : std::uint8_t {
  parameter,   ///< anybody may write it on an axis without an owner, otherwise only the owner
  command,     ///< it moves the axis: writing it on an axis without an owner takes control
  test_input,  ///< it is an input of the test bench: anybody may write it on any axis
};

/// The effect of an accepted write, apart from storing the value in the register.
enum class Change : std::uint8_t {
  limits,          ///< values derived from registers: limits, windows, units
  torque_limits,   ///< the same, and the limits of the servo
  gear,            ///< the same, and the ratio of motor and load
  nothing,         ///< nothing: the next set-point reads the register
  plan,            ///< the motion in progress is planned again
  target,          ///< the active mode takes it as its target
  planned_target,  ///< the active mode takes it as its target and plans again
  power,           ///< the power state machine, and the command to the active mode (6040h)
  mode,            ///< the operating mode (6060h)
  record,          ///< the active mode takes it as its next data record (60C1h:01)
  records,         ///< waiting data records of interpolated position are dropped (60C4h)
  history,         ///< the error history is cleared (1003h)
  habits,          ///< the habits of the drive (5E20h)
  probe,           ///< the touch probes are enabled or disabled (60B8h)
  connection,      ///< 0 -> 1 loses the connection to the master (5E0Ah)
  power_drop,      ///< 0 -> 1 removes the power from an enabled axis (5E0Bh)
  memory,          ///< the owner of the bank stores or restores parameters (1010h, 1011h)
};

/// One row of the object dictionary. All text is static.
struct ObjectDescription {
  ObjectAddress address;
  std::string_view name;
  std::string_view name_zh;
  std::string_view category;
  std::string_view variable_name;
  DataType data_type;
  Access access;
  Storage storage;
  Effective effective;
  std::int64_t lower_limit;
  std::int64_t upper_limit;
  std::int64_t default_value;
  std::string_view units;
  Origin origin;
  Role role = Role::parameter;
  Change change = Change::limits;
};

/// Lowest and highest value that a data type can hold.
struct TypeRange {
  std::int64_t lowest;
  std::int64_t highest;
};

/// @return `visit(number)`, where `number` has the C++ type for `type`.
template <typename Visit>
constexpr auto with_type(DataType type, const Visit& visit) {
  switch (type) {
    case DataType::integer8:
      return visit(std::int8_t{});
    case DataType::integer16:
      return visit(std::int16_t{});
    case DataType::integer32:
      return visit(std::int32_t{});
    case DataType::unsigned8:
      return visit(std::uint8_t{});
    case DataType::unsigned16:
      return visit(std::uint16_t{});
    case DataType::unsigned32:
      break;
  }
  return visit(std::uint32_t{});
}

/// @return the range of `type`.
[[nodiscard]] constexpr TypeRange range_of(DataType type) noexcept {
  return with_type(type, []<typename Number>(Number /*any*/) -> TypeRange {
    return {std::numeric_limits<Number>::min(), std::numeric_limits<Number>::max()};
  });
}

/// @return the size of `type` [bytes].
[[nodiscard]] constexpr std::uint8_t size_of(DataType type) noexcept {
  return with_type(type, []<typename Number>(Number /*any*/) -> std::uint8_t {
    return sizeof(Number);
  });
}

/// @return the manual's spelling of `type`, such as "UNS16" or "INTEGER32".
[[nodiscard]] std::string_view to_string(DataType type) noexcept;

/// @return "RO" or "RW".
[[nodiscard]] std::string_view to_string(Access access) noexcept;

/// @return the name of the enumerator, such as "at_set_point".
[[nodiscard]] std::string_view to_string(Effective effective) noexcept;

}  // namespace vdrive
