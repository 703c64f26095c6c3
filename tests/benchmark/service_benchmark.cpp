// SPDX-License-Identifier: Apache-2.0
//
// How much faster than time a free-running bench goes: drive time over wall time of its tick
// thread on one core, all axes moving, the status taken away as the status thread would. Prints
// one JSON line: the median of the repetitions.
#include "freerun_driver.hpp"
#include "support/local_inbox.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <vector>

namespace {

using namespace vdrive;

constexpr std::uint16_t kAxes = 64;
constexpr std::size_t kRepetitions = 9;
constexpr std::uint64_t kTicks = 50'000;
constexpr std::uint64_t kSession = 1;

/// A write of the axis that the service takes for one of a client.
msg::Request write(std::uint16_t axis, std::uint16_t index, std::int64_t value) {
  static std::uint64_t last_request = 0;
  msg::Request request;
  request.client(1);
  request.request_id(++last_request);
  request.bench(1);
  request.session(kSession);
  request.kind(msg::REQUEST_WRITE);
  auto& object = request.objects().emplace_back();
  object.axis(axis);
  object.index(index);
  object.value(value);
  return request;
}

struct Bench {
  Bench()
      : inbox(1, counters),
        outbox(kAxes),
        engine(configuration(), {.bench = 1, .incarnation = 1}, outbox, counters),
        driver(engine, inbox, outbox, timer) {}

  static service::Configuration configuration() {
    service::Configuration with;
    with.clock = service::ClockMode::freerun;
    with.axes = service::default_axes(kAxes);
    return with;
  }

  void ticks(std::uint64_t count) {
    for (std::uint64_t tick = 0; tick < count; ++tick) {
      driver.cycle();
      while (outbox.status.front() != nullptr) outbox.status.pop();
      while (outbox.replies.front() != nullptr) outbox.replies.pop();
      while (outbox.parameters.front() != nullptr) outbox.parameters.pop();
      while (outbox.events.front() != nullptr) outbox.events.pop();
    }
  }

  /// Far enough to move all the time.
  void set_moving() {
    for (std::uint16_t axis = 1; axis <= kAxes; ++axis) {
      const std::array<std::pair<std::uint16_t, std::int64_t>, 5> writes{{{0x6060, 1},
                                                                          {0x607A, 2'000'000'000},
                                                                          {0x6081, 1'000 + axis},
                                                                          {0x6040, 0x0F},
                                                                          {0x6040, 0x3F}}};
      for (const auto& [index, value] : writes) {
        inbox.receive(write(axis, index, value), {});
        ticks(1);
      }
    }
  }

  [[nodiscard]] bool is_moving() const {
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      if (engine.bank().status(axis).velocity_demand_value == 0) return false;
    }
    return true;
  }

  service::Counters counters;
  test::LocalInbox inbox;
  service::Outbox outbox;
  service::BenchEngine engine;
  service::SystemCycleTimer timer;
  service::FreerunDriver driver;
};

}  // namespace

int main() {
  Bench bench;
  bench.set_moving();
  std::vector<double> ratios;
  for (std::size_t repetition = 0; repetition < kRepetitions; ++repetition) {
    const auto begin = std::chrono::steady_clock::now();
    bench.ticks(kTicks);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    const std::chrono::duration<double> drive = Bench::configuration().period * kTicks;
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
