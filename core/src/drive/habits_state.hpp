// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/power_state_machine.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

/// Which changes of 6060h a drive refuses (5E20h:05).
struct ModeChangeRefusal {
  bool under_halt = false;          // while bit 8 of 6040h is 1
  bool behind_switched_on = false;  // in Operation enabled and in the states of stops and faults
};

/// Habits of other drives, 5E20h, in the form in which they are asked for. As they are made here
/// the drive has none of them.
struct Habits {
  std::uint32_t loop = 0;      // :06, ticks between two looks at 6040h; 0 = each word is obeyed
  std::uint32_t power_on = 0;  // :07, ticks from Enable operation to transition 4
  std::uint32_t mode = 0;      // :08, ticks by which 6061h is late
  std::uint32_t reset = 0;     // :09, ticks from the reset to transition 15

  Transition16 transition_16 = Transition16::by_option_code;  // :04

  ModeChangeRefusal mode_change;       // :05
  bool acknowledges_enabling = false;  // :01
  bool gates_stream = false;           // :02
  bool cuts_quick_stop = false;        // :03
  bool shows_points = false;           // :0A
  bool plans_from_rest = false;        // :0B
  bool homes_by_level = false;         // :0D
  bool clears_velocity = false;        // :0E
  bool ends_homing_at_halt = false;    // :0F
  bool needs_mode = false;             // :10
  std::array<std::uint8_t, 4> unused{};
};

/// What a habit holds back at present. Counts are ticks, the present one included; 0 = nothing.
struct HabitWaits {
  std::uint32_t look = 0;      // at 6040h; counts in every tick
  std::uint32_t power_on = 0;  // transition 4
  std::uint32_t mode = 0;      // 6061h
  std::uint32_t reset = 0;     // transition 15
  std::uint16_t word = 0;      // 6040h as it was written last
  bool has_word = false;       // and nobody has looked at it
  std::array<std::uint8_t, 5> unused{};
};

}  // namespace vdrive
