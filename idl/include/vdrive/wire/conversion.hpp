// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_bank.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/clock_mode.hpp"
#include "vdrive/unit.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <string>

namespace vdrive::wire {

/// The owner of an axis, as shown in the status.
struct Ownership {
  std::uint64_t session = 0;  ///< 0 = free
  std::uint32_t epoch = 0;
  std::uint64_t last_sequence = 0;  ///< number of the owner's last applied command frame
};

/// Address of an axis on the network.
struct AxisAddress {
  std::uint32_t bench = 0;
  std::uint16_t axis = 0;  ///< number on its bench, from 1
};

/// Fills `message` with the status image.
void to_message(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
                const Ownership& owner, msg::AxisStatus& message);

/// @return the status image that `message` carries.
[[nodiscard]] AxisStatus from_message(const msg::AxisStatus& message);

/// Fills `message` with every writable object of the manual, read from axis `index` of `bank`.
void to_message(const AxisBank& bank, std::size_t index, const AxisAddress& address,
                std::uint64_t tick, msg::AxisParameters& message);

[[nodiscard]] msg::ClockMode to_message(ClockMode mode) noexcept;

/// @return the mode; realtime for a number that is not in the IDL.
[[nodiscard]] ClockMode from_message(msg::ClockMode mode) noexcept;

/// Copies the unit of an axis into its description.
void to_message(const Unit& unit, msg::AxisDescription& message);

/// @return the unit in the description; the default unit if it has no usable one.
[[nodiscard]] Unit unit_of(const msg::AxisDescription& message);

/// @return a description of `reason`, a value of msg::Reason or a CiA 301 abort code.
[[nodiscard]] std::string describe_reason(std::uint32_t reason);

}  // namespace vdrive::wire
