// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/power_state_machine.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

/// The changes of 6060h that a drive refuses (5E20h:05).
struct ModeChangeRefusal {
  bool under_halt = false;          // while bit 8 of 6040h is 1
  bool beyond_switched_on = false;  // in Operation enabled, during stops, in a fault
};

/// Habits of other drives, 5E20h, in the form that the code uses. By default the drive has none.
struct Habits {
  std::uint32_t loop = 0;      // :06, ticks between two reads of 6040h; 0 = every word is obeyed
  std::uint32_t power_on = 0;  // :07, ticks from Enable operation to transition 4
  std::uint32_t mode = 0;      // :08, ticks by which 6061h is delayed
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

/// Actions that a habit is holding back, each with its ticks left, the next one included; 0 = none.
struct HabitWaits {
  std::uint32_t look = 0;      // read of 6040h; starts again each time
  std::uint32_t power_on = 0;  // transition 4
  std::uint32_t mode = 0;      // 6061h
  std::uint32_t reset = 0;     // transition 15
  std::uint16_t word = 0;      // last written value of 6040h
  bool has_word = false;       // `word` has not been read yet
  std::array<std::uint8_t, 5> unused{};
};

}  // namespace vdrive
