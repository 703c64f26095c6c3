// SPDX-License-Identifier: Apache-2.0
// A bench in this process: what it costs to make one, and to step it.
//
//   vdrive_local_benchmark [STEPS]     one JSON line a figure: median and 99th percentile
#include <nlohmann/json.hpp>
#include <vdrive/bench/bench.hpp>
#include <vdrive/client.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iostream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace vdrive::client;
using vdrive::bench::Bench;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kAxes = 64;
constexpr std::size_t kRecorded = 10'000;  // ticks

void print(std::string_view what, std::vector<double> times, std::string_view unit) {
  std::ranges::sort(times);
  std::cout << nlohmann::json{{"what", what},
                              {"p50", times.at(times.size() / 2)},
                              {"p99", times.at(times.size() * 99 / 100)},
                              {"unit", unit}}
            << '\n';
}

/// @return how long each of `count` calls took [us].
template <typename Call>
std::vector<double> times_of(std::size_t count, const Call& call) {
  std::vector<double> times;
  times.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto begin = Clock::now();
    call();
    times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  return times;
}

void require(const Outcome& outcome) {
  if (!outcome) throw std::runtime_error(outcome.message());
}

/// Every axis moves far, slowly enough to move all the time, each to its own place.
void let_all_move(Session& session) {
  auto axes = session.axes(1).value();
  for (Axis& axis : axes) {
    require(axis.enable());
    const std::int32_t target = 1'000'000'000 + 1'000 * axis.id().axis;
    require(axis.move_to(target, {.velocity = 40'000, .call = {.until = Until::in_force}}));
  }
}

void measure_steps(std::size_t steps) {
  const Bench bench({.axes = kAxes});
  Session session = bench.session();
  let_all_move(session);
  print("one-tick step, 64 axes moving, none shown",
        times_of(steps,
                 [&] {
                   static_cast<void>(session.step(1, 1).value());
                 }),
        "us");
  std::vector<AxisId> ids;
  for (const Axis& axis : session.axes(1).value()) ids.push_back(axis.id());
  Follower follower = session.follow(ids, Pace::drive).value();
  Observation sample;
  print("the same, all shown",
        times_of(steps,
                 [&] {
                   require(follower.next(std::chrono::seconds(1), sample));
                 }),
        "us");
  std::vector<AxisSnapshot> recorded(kRecorded * kAxes);
  print("10 s of drive time, 64 axes moving, every tick kept",
        times_of(9,
                 [&] {
                   auto place = recorded.begin();
                   for (std::size_t tick = 0; tick < kRecorded; ++tick) {
                     require(follower.next(std::chrono::seconds(1), sample));
                     place = std::ranges::copy(sample.axes, place).out;
                   }
                 }),
        "us");
  print("10 s of drive time, 64 axes moving, nobody looks",
        times_of(9,
                 [&] {
                   static_cast<void>(session.wait(1, std::chrono::seconds(10)).value());
                 }),
        "us");
}

void measure_lives() {
  print("bench of two axes made, first axis read, ended",
        times_of(101,
                 [] {
                   const Bench bench({.axes = 2});
                   Session session = bench.session();
                   static_cast<void>(session.axis("1.1").value().status().value());
                 }),
        "us");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::span arguments(argv, static_cast<std::size_t>(argc));
    measure_steps(arguments.size() > 1 ? std::stoul(arguments[1]) : 20'000);
    measure_lives();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
