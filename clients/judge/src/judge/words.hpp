// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/axis_track.hpp"
#include "judge/finding.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::judge {

/// The notation of values in findings and reports.

/// @return four digits, such as "0x001F".
[[nodiscard]] std::string hex_text(std::uint16_t word);

/// @return the duration with three digits, or all digits before the point, truncated and not
///         rounded, such as "400 us", "12.5 ms" or "1250 s".
[[nodiscard]] std::string duration_text(Time time);

/// @return a time of the source, such as "12.345678 s", or with a tick "tick 12345".
[[nodiscard]] std::string place_text(const Place& place);

/// @return such as "Operation enabled, mode 1 (profile position)".
[[nodiscard]] std::string state_and_mode_text(const AxisTrack& track);

/// @return the command in a controlword, with its other bits, such as "enable operation, new
///         set-point".
[[nodiscard]] std::string controlword_text(std::uint16_t word, std::int8_t mode);

/// @return the state, and the other bits of the statusword, such as "Operation enabled, target
///         reached".
[[nodiscard]] std::string statusword_text(std::uint16_t word, std::int8_t mode);

/// @return such as "mode 8 (cyclic synchronous position)".
[[nodiscard]] std::string mode_text(std::int8_t mode);

/// @return such as "607Ah" or "607Dh:2".
[[nodiscard]] std::string object_name(ObjectAddress object);

/// @return what the master is waiting for, such as "bit 12 = 1"; empty if nothing.
[[nodiscard]] std::string_view waiting_text(Waiting waiting) noexcept;

/// @return the change in a line of the table, such as "6040h = 0x001F", "6041h" or "emergency
///         0x8611 ..."; for a failed write also how it failed, such as "(too late)".
[[nodiscard]] std::string event_text(const Line& line);

/// @return the author: "SDO", "RPDO 1", "request 0x0123456789abcdef" or "frame 0x0123456789abcdef"
///         with the session on a bench, "master" for NMT commands, otherwise "drive".
[[nodiscard]] std::string writer_text(const Line& line);

}  // namespace vdrive::judge
