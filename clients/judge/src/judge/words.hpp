// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/axis_track.hpp"
#include "judge/finding.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::judge {

/// How findings and reports spell what they show.

/// @return four digits, such as "0x001F".
[[nodiscard]] std::string hex_text(std::uint16_t word);

/// @return three digits or those before the point, cut and not rounded, such as "400 us",
///         "12.5 ms" or "1250 s".
[[nodiscard]] std::string duration_text(Time time);

/// @return a time of the source, such as "12.345678 s", or with a tick "tick 12345".
[[nodiscard]] std::string place_text(const Place& place);

/// @return such as "Operation enabled, mode 1 (profile position)".
[[nodiscard]] std::string state_and_mode_text(const AxisTrack& track);

/// @return what a controlword commands, with its further bits, such as
///         "enable operation, new set-point".
[[nodiscard]] std::string controlword_text(std::uint16_t word, std::int8_t mode);

/// @return the state, and the other bits of the statusword, such as
///         "Operation enabled, target reached".
[[nodiscard]] std::string statusword_text(std::uint16_t word, std::int8_t mode);

/// @return such as "mode 8 (cyclic synchronous position)".
[[nodiscard]] std::string mode_text(std::int8_t mode);

/// @return such as "607Ah" or "607Dh:2".
[[nodiscard]] std::string object_name(ObjectAddress object);

/// @return what the master waits for, such as "bit 12 = 1"; empty for nothing.
[[nodiscard]] std::string_view waiting_text(Waiting waiting) noexcept;

/// @return what a line of the table says happened, such as "6040h = 0x001F", "6041h" or
///         "emergency 0x8611 ..."; of a write that has failed also how, such as "(too late)".
[[nodiscard]] std::string event_text(const Line& line);

/// @return by whom: "SDO", "RPDO 1", "request 0x0123456789abcdef" or "frame 0x0123456789abcdef"
///         with the session of a bench, "master" for NMT commands, else "drive".
[[nodiscard]] std::string writer_text(const Line& line);

}  // namespace vdrive::judge
