// SPDX-License-Identifier: Apache-2.0
#include "churn/roles.hpp"

#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/outcome.hpp"

#include <poll.h>
#include <unistd.h>

#include <iostream>
#include <mutex>

namespace vdrive::churn {

using namespace std::chrono_literals;

namespace {

using Clock = std::chrono::steady_clock;

/// The shortest pause to print.
constexpr auto kPause = 5ms;
constexpr auto kTellEach = 100ms;

double seconds(Clock::time_point time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

constexpr std::uint16_t kPositioningOption = 0x60F2;
constexpr std::uint16_t kActualPosition = 0x6064;

/// The multiple of kStep that is nearest to `position`.
std::int32_t nearest_step(std::int64_t position) {
  const std::int64_t half = position >= 0 ? kStep / 2 : -kStep / 2;
  return static_cast<std::int32_t>((position + half) / kStep * kStep);
}

}  // namespace

bool is_stop_requested() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return poll(&input, 1, 0) > 0;
}

void print_line(Json line) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  line["time"] = seconds(Clock::now());
  std::cout << line.dump() << std::endl;
}

void print_failure(const std::string& call, const client::Outcome& outcome) {
  print_line(
      {{"failed", call}, {"kind", to_string(outcome.kind())}, {"message", outcome.message()}});
}

bool Pauses::note() {
  const auto now = Clock::now();
  if (last_ != Clock::time_point() && now - last_ >= kPause) {
    print_line({{"pause", {seconds(last_), seconds(now)}}});
  }
  last_ = now;
  if (now - told_ < kTellEach) return false;
  told_ = now;
  return true;
}

client::MoveOptions quick(client::Until until) {
  return {.velocity = 20'480,
          .acceleration = 204'800,
          .deceleration = 204'800,
          .queue = false,
          .call = {.until = until}};
}

client::Result<std::int32_t> prepare(client::Axis& axis) {
  if (auto done = axis.acquire(); !done) return done;
  if (auto done = axis.reset_fault(); !done) return done;
  // Relative moves add to the previous target, so rounding and position errors do not accumulate.
  if (auto done = axis.write({kPositioningOption, 0}, 0); !done) return done.outcome();
  if (auto done = axis.enable(); !done) return done;
  const auto position = axis.read({kActualPosition, 0});
  if (!position) return position.outcome();
  const std::int32_t base = nearest_step(*position);
  if (auto done = axis.move_to(base, quick(client::Until::done)); !done) return done;
  return base;
}

client::Result<std::int32_t> resting_demand(const client::Axis& axis) {
  const auto seen = axis.wait_until(
      [](const client::AxisSnapshot& now) {
        return now.status.velocity_demand_value == 0 && now.shows(Statusword::kTargetReached);
      },
      10s);
  if (!seen) return seen.outcome();
  return seen->status.position_demand_value;
}

int read(const Setting& setting, std::uint16_t axis, std::uint16_t index) {
  client::Session session(setting.network);
  const auto found = session.axis(std::to_string(setting.bench) + "." + std::to_string(axis));
  const auto value =
      found ? found->read({index, 0}) : client::Result<std::int64_t>(found.outcome());
  if (!value) {
    print_failure("read", value.outcome());
    return 1;
  }
  print_line({{"axis", axis}, {"value", *value}});
  return 0;
}

}  // namespace vdrive::churn
