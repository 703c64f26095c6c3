// SPDX-License-Identifier: Apache-2.0
//
// One of several programs that step a bench together, each with its own axis:
//
//   co_stepper DOMAIN AXIS AXES STEPPERS
//
// Prints "joined" when it has joined the clock, then moves its axis and observes all axes at
// intervals that depend on AXIS, and finally prints a digest of all that it observed.
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/client/step_clock.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace std::chrono_literals;
namespace client = vdrive::client;

constexpr std::uint32_t kBench = 1;

class Digest {
 public:
  void add(std::int64_t number) {
    constexpr std::uint64_t kPrime = 0x100000001B3;
    constexpr unsigned kBitsOfByte = 8;
    for (unsigned shift = 0; shift < 64; shift += kBitsOfByte) {
      value_ ^= static_cast<std::uint64_t>(number) >> shift & 0xFFU;
      value_ *= kPrime;
    }
  }

  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325;
};

void require(const client::Outcome& outcome) {
  if (!outcome) throw std::runtime_error(outcome.message());
}

void look(client::Session& session, const std::vector<client::AxisId>& axes, Digest& digest) {
  const auto seen = session.observe(axes);
  require(seen.outcome());
  digest.add(static_cast<std::int64_t>(seen->tick));
  for (const client::AxisSnapshot& axis : seen->axes) {
    digest.add(axis.status.load_position_actual_value);
    digest.add(axis.status.load_velocity_actual_value);
    digest.add(axis.status.torque_actual_value);
    digest.add(axis.status.ds402_statusword);
  }
}

std::uint64_t run(std::uint32_t domain, std::uint16_t number, std::uint16_t count,
                  std::uint32_t steppers) {
  client::SessionOptions options;
  options.domain = domain;
  options.find_timeout = 60s;
  options.silence = 10s;
  client::Session session(options);
  auto clock = client::StepClock::join(session, std::array{kBench}, steppers);
  require(clock.outcome());
  std::cout << "joined" << std::endl;
  const auto awaited = clock->step(1, 60s);  // the other programs are still starting
  require(awaited.outcome());
  std::vector<client::AxisId> axes;
  for (std::uint16_t each = 1; each <= count; ++each) axes.push_back({kBench, each});
  auto axis = session.axis(to_string(axes[number - 1U]));
  require(axis.outcome());
  require(axis->enable());
  Digest digest;
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    require(axis->move_to(number * (round % 2 == 0 ? 1'000 : -500) + round,
                          {.call = {.until = client::Until::in_force}}));
    require(clock->step(5U + 3U * number, 60s).outcome());
    look(session, axes, digest);
  }
  return digest.value();
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 5) return 2;
  try {
    const auto number_at = [&](int place) {
      return static_cast<std::uint32_t>(std::stoul(arguments[place]));
    };
    std::cout << run(number_at(1), static_cast<std::uint16_t>(number_at(2)),
                     static_cast<std::uint16_t>(number_at(3)), number_at(4))
              << std::endl;
  } catch (const std::exception& error) {
    std::cout << error.what() << std::endl;
    return 1;
  }
  return 0;
}
