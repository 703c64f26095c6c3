// SPDX-License-Identifier: Apache-2.0
//
// The gain of a second thread that steps half of a bench: complete ticks of the engine with a
// status image each, in alternating rounds with one thread and with two. In each round two
// independent processes, each with half of the axes, show the upper bound of the machine. Also the
// cost of the barrier between the threads.
//
//   vdrive_threads_benchmark [AXES [ROUNDS]]
//
// Prints JSON lines with the medians of the rounds:
// {"figure":"threads_speedup","axes":16384,"value":...}.
#include "base/step_pool.hpp"
#include "moving_bench.hpp"
#include "support/signals.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <iostream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

using vdrive::test::MovingBench;
using Clock = std::chrono::steady_clock;

double nanoseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() / 2);
}

void print(std::string_view figure, std::size_t axes, double value) {
  std::cout << R"({"figure":")" << figure << R"(","axes":)" << axes << R"(,"value":)" << value
            << "}\n";
}

/// @return the time of the ticks [ns].
double time_of(MovingBench& bench, int ticks) {
  const auto begin = Clock::now();
  for (int tick = 0; tick < ticks; ++tick) bench.tick_with_status();
  return nanoseconds_since(begin);
}

void require(bool condition, const char* what) {
  if (!condition) throw std::runtime_error(what);
}

/// A process with another bench that ticks on request.
class Neighbour {
 public:
  explicit Neighbour(std::uint16_t axes) {
    require(pipe(orders_.data()) == 0 && pipe(answers_.data()) == 0, "no pipe");
    process_ = fork();
    require(process_ >= 0, "no process");
    if (process_ == 0) run(axes);
  }

  ~Neighbour() {
    vdrive::test::send_signal(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    for (const int end : {orders_[0], orders_[1], answers_[0], answers_[1]}) close(end);
  }

  Neighbour(const Neighbour&) = delete;
  Neighbour& operator=(const Neighbour&) = delete;

  void begin(int ticks) const {
    require(write(orders_[1], &ticks, sizeof(ticks)) == sizeof(ticks), "no partner");
  }

  /// @return the time of its ticks [ns].
  [[nodiscard]] double end() const {
    double time = 0.0;
    require(read(answers_[0], &time, sizeof(time)) == sizeof(time), "no partner");
    return time;
  }

 private:
  [[noreturn]] void run(std::uint16_t axes) const {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    MovingBench bench(axes, 1);
    int ticks = 0;
    while (read(orders_[0], &ticks, sizeof(ticks)) == sizeof(ticks)) {
      const double time = time_of(bench, ticks);
      if (write(answers_[1], &time, sizeof(time)) != sizeof(time)) break;
    }
    _exit(0);
  }

  std::array<int, 2> orders_{};
  std::array<int, 2> answers_{};
  pid_t process_ = 0;
};

/// @return the time that the threads of a pool need to begin and end a tick together [us]: two
///         threads with a block of eight axes each, less one thread with one block.
double barrier() {
  constexpr std::size_t kLanes = 8;
  constexpr int kTicks = 20'000;
  constexpr int kRounds = 9;
  constexpr std::chrono::microseconds kPeriod{1'000};
  const std::vector<vdrive::AxisConfiguration> axes(2 * kLanes);
  const std::span<const vdrive::AxisConfiguration> all(axes);
  vdrive::AxisBank small(all.first(kLanes), kPeriod);
  vdrive::AxisBank large(all, kPeriod);
  vdrive::service::StepPool alone(small, 1);
  vdrive::service::StepPool pair(large, 2);
  const auto time = [](vdrive::service::StepPool& pool) {
    const auto begin = Clock::now();
    for (int tick = 0; tick < kTicks; ++tick) pool.step();
    return nanoseconds_since(begin) / kTicks * 1e-3;
  };
  std::vector<double> costs;
  for (int round = 0; round < kRounds; ++round) {
    const double without = time(alone);
    costs.push_back(time(pair) - without);
  }
  return median(costs);
}

void measure(std::uint16_t axes, int rounds) {
  const auto half = static_cast<std::uint16_t>(axes / 2);
  const int ticks = std::max(1, 1'000'000 / axes);
  const std::array<Neighbour, 2> neighbours{Neighbour(half), Neighbour(half)};
  MovingBench one(axes, 1);
  MovingBench two(axes, 2);
  std::vector<double> times;
  std::vector<double> by_threads;
  std::vector<double> by_processes;
  for (int round = 0; round < rounds; ++round) {
    const double alone = time_of(one, ticks);
    times.push_back(alone / ticks / axes);
    by_threads.push_back(alone / time_of(two, ticks));
    for (const Neighbour& neighbour : neighbours) neighbour.begin(ticks);
    by_processes.push_back(alone / std::max(neighbours[0].end(), neighbours[1].end()));
  }
  require(one.is_moving() && two.is_moving(), "an axis stopped moving");
  print("engine_tick_ns", axes, median(times));
  print("threads_speedup", axes, median(by_threads));
  print("processes_speedup", axes, median(by_processes));
}

int run(const std::vector<std::string>& words) {
  const std::uint16_t axes =
      words.empty() ? std::uint16_t{16'384} : static_cast<std::uint16_t>(std::stoul(words[0]));
  measure(axes, words.size() < 2 ? 15 : std::stoi(words[1]));
  std::cout << R"({"figure":"threads_barrier_us","value":)" << barrier() << "}\n";
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run({arguments + 1, arguments + count});
  } catch (const std::exception& error) {
    std::cerr << "vdrive_threads_benchmark: " << error.what() << '\n';
    return 1;
  }
}
