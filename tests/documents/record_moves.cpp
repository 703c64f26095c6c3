// SPDX-License-Identifier: Apache-2.0
// Records the moves for the plots in the documents directly from the core, so the numbers are the
// same on every machine. Prints every tick in the CSV format of `vdrive record`, for `vdrive plot`.
//
//   record_moves forward|blocked
#include "core/support/axis_under_test.hpp"
#include "text_recording.hpp"

#include <chrono>
#include <cstdint>
#include <exception>
#include <iostream>
#include <memory>
#include <string_view>

namespace {

using vdrive::test::AxisUnderTest;

constexpr vdrive::client::AxisId kAxis{1, 1};

void record_ticks(AxisUnderTest& axis, std::uint64_t from, std::uint64_t to,
                  vdrive::recording::TextRecording& recording) {
  for (std::uint64_t tick = from; tick < to; ++tick) {
    vdrive::client::Observation seen;
    seen.tick = tick;
    seen.axes.push_back({.id = kAxis, .tick = tick, .status = axis.status()});
    recording.status(seen);
    axis.step();
  }
}

struct StandardOutput final : vdrive::recording::Output {
  void write(std::string_view bytes) override { std::cout << bytes; }
};

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
  constexpr std::uint64_t kForward = 10'600;  // 10.17 s plus the time in the position window
  constexpr std::uint64_t kBlockedAt = 1'000;
  constexpr std::uint64_t kBlocked = 2'000;
  vdrive::recording::TextRecording recording(std::make_unique<StandardOutput>(),
                                             vdrive::recording::Format::csv);
  recording.begin({{.number = 1, .axes = {{.id = kAxis, .name = "x", .topic = "x"}}}});
  if (move == "forward") {
    start(axis, {.target = 10'000, .velocity = 1'000, .ramp = 6'000});  // the manual's example
    record_ticks(axis, 0, kForward, recording);
  } else if (move == "blocked") {
    // 0.5 s after the block, the following error reaches 6065h = 20480 UU.
    start(axis, {.target = 100'000, .velocity = 40'000, .ramp = 200'000});
    record_ticks(axis, 0, kBlockedAt, recording);
    axis.write("test_blocked_load", 1);
    record_ticks(axis, kBlockedAt, kBlocked, recording);
  } else {
    std::cerr << "usage: record_moves forward|blocked\n";
    return 2;
  }
  recording.finish({});
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
