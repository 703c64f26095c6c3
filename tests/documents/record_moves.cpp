// SPDX-License-Identifier: Apache-2.0
// Records the moves of the plots in the documents, directly from the core: the same numbers
// on every machine. Prints CSV, one row for each 10 ms of drive time.
//
//   record_moves forward|blocked
#include "core/support/axis_under_test.hpp"

#include <cstdint>
#include <exception>
#include <iostream>
#include <string_view>

namespace {

using vdrive::test::AxisUnderTest;

constexpr std::int64_t kTicksPerRow = 10;

void print_rows(AxisUnderTest& axis, std::int64_t from, std::int64_t to) {
  for (std::int64_t tick = from; tick < to; ++tick) {
    if (tick % kTicksPerRow == 0) {
      const vdrive::AxisStatus& now = axis.status();
      std::cout << tick << ',' << now.position_demand_value << ',' << now.load_position_actual_value
                << ',' << now.velocity_demand_value << ',' << now.load_velocity_actual_value << ','
                << now.load_position_error_value << ',' << now.error_code << '\n';
    }
    axis.step();
  }
}

struct Move {
  std::int64_t target = 0;    // [UU]
  std::int64_t velocity = 0;  // [UU/s]
  std::int64_t ramp = 0;      // [UU/s²]
};

void start(AxisUnderTest& axis, const Move& move) {
  axis.write("op_mode_cmd", 1);
  axis.write("position_user_target_value", move.target);
  axis.write("profile_velocity", move.velocity);
  axis.write("profile_acc", move.ramp);
  axis.write("profile_dec", move.ramp);
  axis.command(0x000F);
  axis.command(0x003F);
}

int record(std::string_view move) {
  AxisUnderTest axis;
  constexpr std::int64_t kForward = 10'600;  // 10.17 s, and the rest in the window
  constexpr std::int64_t kBlockedAt = 1'000;
  constexpr std::int64_t kBlocked = 2'000;
  std::cout << "tick,position_demand_value,load_position_actual_value,velocity_demand_value,"
               "load_velocity_actual_value,load_position_error_value,error_code\n";
  if (move == "forward") {
    start(axis, {.target = 10'000, .velocity = 1'000, .ramp = 6'000});  // the manual's
    print_rows(axis, 0, kForward);
  } else if (move == "blocked") {
    // 0.5 s after the block the error is the window 6065h of 20480 UU.
    start(axis, {.target = 100'000, .velocity = 40'000, .ramp = 200'000});
    print_rows(axis, 0, kBlockedAt);
    axis.write("test_blocked_load", 1);
    print_rows(axis, kBlockedAt, kBlocked);
  } else {
    std::cerr << "usage: record_moves forward|blocked\n";
    return 2;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return record(argc == 2 ? argv[1] : "");
  } catch (const std::exception& error) {
    std::cerr << "record_moves: " << error.what() << '\n';
    return 1;
  }
}
