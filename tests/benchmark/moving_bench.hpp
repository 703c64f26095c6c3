// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/freerun_driver.hpp"
#include "support/local_inbox.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace vdrive::test {

/// A free-running bench without a wire, with all axes moving. Its output is taken from the queues,
/// as by the status and report threads, and discarded.
class MovingBench {
 public:
  /// Starts motions of all axes that last for the complete run.
  MovingBench(std::uint16_t axes, std::uint32_t threads)
      : axes_(axes),
        inbox_(1, counters_),
        outbox_(axes),
        engine_(configuration(axes, threads), {.bench = 1, .incarnation = 1}, outbox_, counters_),
        driver_(engine_, inbox_, outbox_, timer_) {
    for (std::uint16_t axis = 1; axis <= axes; ++axis) set_moving(axis);
    for (std::size_t ticks = 0; ticks < axes; ++ticks) tick();  // sends the changed parameters
  }

  static service::Configuration configuration(std::uint16_t axes, std::uint32_t threads) {
    service::Configuration with;
    with.clock = service::ClockMode::freerun;
    with.axes = service::default_axes(axes);
    with.threads = threads;
    return with;
  }

  /// Runs one cycle of the free-running driver, with a status image per millisecond of wall time.
  void tick() {
    driver_.cycle();
    empty();
  }

  /// Runs one tick as in real time, with a status image of every tick.
  void tick_with_status() {
    engine_.step();
    engine_.queue_status();
    empty();
  }

  [[nodiscard]] bool is_moving() const {
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      if (engine_.bank().status(axis).velocity_demand_value == 0) return false;
    }
    return true;
  }

 private:
  /// Writes like a client.
  void set_moving(std::uint16_t axis) {
    const std::array<std::pair<std::uint16_t, std::int64_t>, 5> writes{{{0x6060, 1},
                                                                        {0x607A, 2'000'000'000},
                                                                        {0x6081, 1'000 + axis % 97},
                                                                        {0x6040, 0x0F},
                                                                        {0x6040, 0x3F}}};
    msg::Request request;
    request.client = 1;
    request.request_id = axis;
    request.bench = 1;
    request.session = 1;
    request.kind = msg::RequestKind::write;
    for (const auto& [index, value] : writes) {
      auto& object = request.objects.emplace_back();
      object.axis = axis;
      object.index = index;
      object.value = value;
    }
    inbox_.receive(request, {});
    constexpr std::uint16_t kRequestsPerTick = 64;
    if (axis % kRequestsPerTick == 0 || axis == axes_) tick();
  }

  void empty() {
    while (outbox_.status.front() != nullptr) outbox_.status.pop();
    while (outbox_.replies.front() != nullptr) outbox_.replies.pop();
    while (outbox_.parameters.front() != nullptr) outbox_.parameters.pop();
    while (outbox_.events.front() != nullptr) outbox_.events.pop();
  }

  std::size_t axes_;
  service::Counters counters_;
  LocalInbox inbox_;
  service::Outbox outbox_;
  service::BenchEngine engine_;
  service::SystemCycleTimer timer_;
  service::FreerunDriver driver_;
};

}  // namespace vdrive::test
