// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

#include <string_view>

namespace vdrive::tool {

/// Texts of --help in addition to those that CLI11 generates.

inline constexpr std::string_view kSummary = "Commands virtual CiA 402 servo drives over DDS.\n";

inline constexpr std::string_view kSummaryOfShell =
    "Commands of this shell, in one session. 'help COMMAND' shows the help of one; 'exit', 'quit' "
    "and Ctrl-D end the shell.\n";

inline constexpr std::string_view kSpelling =
    "AXIS is bench.axis such as 1.1, or a name. OBJECT is 0x6041, 0x607D:1 or a variable_name such "
    "as ds402_statusword. VALUE is decimal or hex as the two's complement of the object's type "
    "(0xFFFFD8F0 is -10000). A position, a speed or a ramp is in user units (UU), or has a unit of "
    "its axis: 90deg, 180deg/s, 900deg/s2, 12.5mm. DURATION is for example 500us, 20ms or 1.5s.";

/// @return the heading of a group of commands.
[[nodiscard]] constexpr std::string_view title_of(CommandGroup group) noexcept {
  switch (group) {
    case CommandGroup::none:
      return "";
    case CommandGroup::observation:
      return "Benches and axes";
    case CommandGroup::power:
      return "Power, faults and stops";
    case CommandGroup::motion:
      return "Motion";
    case CommandGroup::parameters:
      return "Objects and parameters";
    case CommandGroup::bench:
      return "Test bench and clock";
    case CommandGroup::scenarios:
      return "Scenarios";
    case CommandGroup::recordings:
      return "Recordings";
    case CommandGroup::machine:
      return "This machine";
  }
  return "";
}

inline constexpr std::string_view kExamples =
    R"(Examples:
  vdrive list                              all benches and axes
  vdrive enable 1.1                        power on
  vdrive move 1.1 10000 --velocity 1000    absolute, waits until reached
  vdrive move 1.1 -500 --relative          by a distance
  vdrive move 1.1 90deg --velocity 180deg/s
  vdrive home 1.1 --method 37              home is here
  vdrive velocity 1.1 180deg/s             runs on; velocity 1.1 0 stops
  vdrive jog 1.1 90deg/s                   until Enter or Ctrl-C
  vdrive describe 1.1                      state, last fault, model, changed objects
  vdrive watch 1.1                         live, in a second terminal
  vdrive quick-stop 1.1                    from any terminal; vdrive stop stops all axes
  vdrive read 1.1 0x6041 position_demand_value
  vdrive write 1.1 0x607A 0xFFFFD8F0       -10000 as hex
  vdrive record move.csv 1.1 --for 5s      the status stream, one row per tick
  vdrive plot move.csv -o move.svg         a recording as a picture
  vdrive disturb 1.1 blocked_load --for 500ms
  vdrive rate 0                            pause a realtime bench; rate 1 continues
  vdrive wait 1.1 target_reached --timeout 5s
  vdrive events --follow                   faults, refusals, who took control
  vdrive run forward.scn --junit out.xml   a scenario, see 'vdrive run --help'
  vdrive test *.scn --junit out.xml        each on a bench of its own, for CI

Environment: VDRIVE_DOMAIN and VDRIVE_SECURITY are the defaults of --domain and --security; NO_COLOR switches colours off.
Exit codes: 0 ok, 1 failed, 2 usage, 3 not found, 4 timed out, 5 refused, 6 not run, 130 interrupted.)";

}  // namespace vdrive::tool
