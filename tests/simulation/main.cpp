// SPDX-License-Identifier: Apache-2.0
//
// Plays seeds of the simulation; see tests/simulation/run.sh.
#include "simulation/simulation.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <iomanip>
#include <iostream>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace vdrive::simulation;

struct Arguments {
  std::uint64_t first = 1;
  std::uint64_t last = 100;
  std::size_t jobs = std::max(1U, std::thread::hardware_concurrency());
  bool trace = false;
  Options options;
};

/// Reads "FIRST..LAST". @return an error message, or nothing.
std::string read_seeds(const std::string& text, Arguments& arguments) {
  const std::size_t dots = text.find("..");
  try {
    std::size_t end_of_first = 0;
    std::size_t end_of_last = 0;
    arguments.first = std::stoull(text, &end_of_first);
    arguments.last = dots == std::string::npos ? arguments.first
                                               : std::stoull(text.substr(dots + 2), &end_of_last);
    const bool is_whole = end_of_first == std::min(dots, text.size()) &&
                          (dots == std::string::npos || dots + 2 + end_of_last == text.size());
    if (is_whole && arguments.first <= arguments.last) {
      return {};
    }
  } catch (const std::exception&) {
    // reported below
  }
  return "'" + text + "' is not FIRST..LAST of two whole numbers in ascending order";
}

void print(const Violation& violation, const Report& report, const Options& options) {
  std::cout << "seed " << report.seed << ", tick " << violation.tick;
  if (violation.axis != 0) std::cout << ", axis " << violation.axis;
  std::cout << ": violated: " << violation.invariant << "\n  expected: " << violation.expected
            << "\n  seen:     " << violation.seen << "\n  again:    vdrive_simulation --seed "
            << report.seed << " --seconds " << options.seconds << " --axes " << options.axes
            << (options.play == Play::fight ? " --fight" : "") << " --trace --stop-at-tick "
            << violation.tick << '\n';
}

/// Plays all seeds in as many threads as there are jobs. @return the number of seeds that failed.
std::size_t play(const Arguments& arguments, Report& sum) {
  std::atomic<std::uint64_t> next = arguments.first;
  std::mutex output;
  std::size_t failed = 0;
  const auto work = [&] {
    for (std::uint64_t seed = next++; seed <= arguments.last; seed = next++) {
      Options options = arguments.options;
      options.seed = seed;
      options.trace = arguments.trace ? &std::cout : nullptr;
      const Report report = simulate(options);
      const std::lock_guard lock(output);
      sum.add(report);
      if (report.violation) {
        ++failed;
        print(*report.violation, report, options);
      } else if (arguments.first == arguments.last) {
        std::cout << "seed " << seed << ": hash " << std::hex << report.hash << std::dec << '\n';
      }
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t job = 1; job < arguments.jobs && !arguments.trace; ++job) {
    threads.emplace_back(work);
  }
  work();
  threads.clear();
  return failed;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  std::string seeds = "1..100";
  std::uint64_t seed = 0;
  bool fight = false;
  const std::map<std::string, vdrive::service::ClockMode> clocks{
      {"realtime", vdrive::service::ClockMode::realtime},
      {"lockstep", vdrive::service::ClockMode::lockstep},
      {"freerun", vdrive::service::ClockMode::freerun}};
  CLI::App app{"Plays a bench, two masters, a bad network and a bad host, by seeds."};
  auto* const range = app.add_option("--seeds", seeds, "FIRST..LAST, default 1..100");
  app.add_option("--seed", seed, "one seed")->excludes(range);
  app.add_option("--seconds", arguments.options.seconds, "drive time of each seed, default 60")
      ->check(CLI::PositiveNumber);
  app.add_option("--axes", arguments.options.axes, "axes of the bench, default 16")
      ->check(CLI::Range(1, 256));
  app.add_option("--threads", arguments.options.threads, "that step the bank, default 1")
      ->check(CLI::Range(1, 64));
  app.add_option("--jobs", arguments.jobs, "seeds at a time, default: all processors")
      ->check(CLI::Range(1, 1024));
  app.add_option("--clock", arguments.options.clock, "realtime, lockstep, freerun; default by seed")
      ->transform(CLI::CheckedTransformer(clocks));
  app.add_option("--stop-at-tick", arguments.options.stop_at_tick, "end after this tick");
  app.add_flag("--fight", fight, "two masters over the axes all the time, nothing else");
  app.add_flag("--trace", arguments.trace, "print what happens");
  CLI11_PARSE(app, argc, argv);
  if (app.count("--seed") != 0) seeds = std::to_string(seed);
  if (const std::string error = read_seeds(seeds, arguments); !error.empty()) {
    std::cerr << "vdrive_simulation: " << error << '\n';
    return 2;
  }
  spdlog::set_level(spdlog::level::off);  // disks fail in many seeds
  arguments.options.play = fight ? Play::fight : Play::everything;
  const auto begin = std::chrono::steady_clock::now();
  Report sum;
  const std::size_t failed = play(arguments, sum);
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::cout << std::fixed << std::setprecision(1) << arguments.last - arguments.first + 1
            << " seeds, " << failed << " failed; " << sum.ticks << " ticks, " << sum.commands
            << " commands executed, " << sum.refused_frames << " frames refused, "
            << sum.lost_masters << " masters lost, " << sum.jumps << " jumps, " << sum.restarts
            << " restarts, " << sum.stores << " stores, " << sum.failed_stores << " failed stores, "
            << sum.cut_saves << " saves cut short\n"
            << sum.seconds << " s of drive time in " << wall << " s: " << sum.seconds / wall
            << " times real time with " << arguments.jobs << " jobs on "
            << std::thread::hardware_concurrency() << " processors\n";
  return failed == 0 ? 0 : 1;
}
