// SPDX-License-Identifier: Apache-2.0
//
// How much faster than real time a free-running bench runs: drive time over wall time of its tick
// thread on one core, with all axes moving. The status is taken from the queue as by the status
// thread, and discarded. Prints one JSON line: the median of the repetitions.
#include "moving_bench.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <vector>

namespace {

using vdrive::test::MovingBench;

constexpr std::uint16_t kAxes = 64;
constexpr std::size_t kRepetitions = 9;
constexpr std::uint64_t kTicks = 50'000;

}  // namespace

int main() {
  MovingBench bench(kAxes, 1);
  std::vector<double> ratios;
  for (std::size_t repetition = 0; repetition < kRepetitions; ++repetition) {
    const auto begin = std::chrono::steady_clock::now();
    for (std::uint64_t tick = 0; tick < kTicks; ++tick) bench.tick();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    const std::chrono::duration<double> drive =
        MovingBench::configuration(kAxes, 1).period * kTicks;
    ratios.push_back(drive / wall);
  }
  if (!bench.is_moving()) {
    std::cerr << "an axis stopped moving: the figure would not be that of moving axes\n";
    return 1;
  }
  std::sort(ratios.begin(), ratios.end());
  std::cout << R"({"figure":"freerun_times_real_time","axes":)" << kAxes << R"(,"value":)"
            << ratios[kRepetitions / 2] << "}\n";
  return 0;
}
