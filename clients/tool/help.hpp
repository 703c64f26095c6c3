// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace vdrive::tool {

/// Texts of --help beside what CLI11 makes itself.

inline constexpr std::string_view kSummary =
    "Commands virtual CiA 402 servo drives over DDS.\n"
    "AXIS is bench.axis such as 1.1, or a name. OBJECT is 0x6041, 0x607D:1 or a variable_name such "
    "as ds402_statusword. VALUE is decimal or hex as the two's complement of the object's type "
    "(0xFFFFD8F0 is -10000). DURATION is for example 500us, 20ms or 1.5s.";

inline constexpr std::string_view kExamples =
    R"(Examples:
  vdrive list                              all benches and axes
  vdrive enable 1.1                        power on
  vdrive move 1.1 10000 --velocity 1000    absolute, waits until reached
  vdrive move 1.1 -500 --relative          by a distance
  vdrive watch 1.1                         live, in a second terminal
  vdrive quick-stop 1.1                    from any terminal; vdrive stop stops all axes
  vdrive read 1.1 0x6041 position_demand_value
  vdrive write 1.1 0x607A 0xFFFFD8F0       -10000 as hex
  vdrive record move.csv 1.1 --for 5s      the status stream, one row a tick
  vdrive disturb 1.1 blocked_load --for 500ms
  vdrive rate 0                            pause a realtime bench; rate 1 continues
  vdrive run forward.scn --junit out.xml   a scenario, see 'vdrive run --help'

Environment: VDRIVE_DOMAIN and VDRIVE_SECURITY are the defaults of --domain and --security; NO_COLOR switches colours off.
Exit codes: 0 ok, 1 failed, 2 usage, 3 not found, 4 timed out, 5 refused, 130 interrupted.)";

inline constexpr std::string_view kDisturbanceHelp =
    "load_torque [mN.m], blocked_load, over_current, over_temperature, encoder_failure, "
    "dc_link_loss, positive_limit, negative_limit, home_switch, index_pulse, or none: clears all";

inline constexpr std::string_view kScenarioHelp =
    R"(A scenario has one command a line, without 'vdrive'. # starts a comment.
Three commands exist only in scenarios:
  expect AXIS OBJECT VALUE [--mask M | --tolerance T] [--within D | --throughout D]
  wait DURATION
  refused CODE COMMAND...
In lock-step, commands that wait step the clock. The first failure ends the run.

Example:
  enable 1.1
  write 1.1 0x607A 10000
  write 1.1 0x6040 0x3F
  expect 1.1 0x6041 0x1237 --within 2ms
  expect 1.1 0x6041 0x1637 --within 11s    # arrived
  refused 0x06010002 write 1.1 0x6041 0    # read-only)";

}  // namespace vdrive::tool
