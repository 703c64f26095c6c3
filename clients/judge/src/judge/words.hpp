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

/// @return such as "0x1F"; at least four digits of a word: "0x001F".
[[nodiscard]] std::string hex_text(std::uint16_t word);

/// @return such as "0.4 ms" or "12.5 s".
[[nodiscard]] std::string duration_text(Time time);

/// @return a time of the source, such as "12.345678 s", or with a tick "tick 12345".
[[nodiscard]] std::string place_text(const Place& place);

/// @return such as "Operation enabled, mode 1 (profile position)".
[[nodiscard]] std::string state_and_mode_text(const AxisTrack& track);

/// @return what a controlword commands, with its further bits, such as
///         "enable operation, new set-point".
[[nodiscard]] std::string controlword_text(std::uint16_t word, std::int8_t mode);

/// @return the state, and the bits of the statusword beside it, such as
///         "Operation enabled, target reached".
[[nodiscard]] std::string statusword_text(std::uint16_t word, std::int8_t mode);

/// @return such as "mode 8 (cyclic synchronous position)".
[[nodiscard]] std::string mode_text(std::int8_t mode);

/// @return such as "607Ah" or "607Dh:2".
[[nodiscard]] std::string object_name(ObjectAddress object);

/// @return what the master waits for, such as "bit 12 = 1"; empty for nothing.
[[nodiscard]] std::string_view waiting_text(Waiting waiting) noexcept;

/// @return what a line of the table says happened, such as "6040h = 0x001F by SDO".
[[nodiscard]] std::string event_text(const Line& line);

/// @return by whom, such as "master, SDO", "session 12ab", or "drive".
[[nodiscard]] std::string writer_text(const Line& line);

}  // namespace vdrive::judge
