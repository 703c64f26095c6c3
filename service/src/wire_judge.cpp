// SPDX-License-Identifier: Apache-2.0
#include "wire_judge.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kMebi = 1'024ULL * 1'024ULL;

}  // namespace

std::uint64_t WireLoss::packed() const noexcept {
  return std::uint64_t{static_cast<std::uint8_t>(cause)} << 32U | value;
}

WireLoss WireLoss::unpacked(std::uint64_t detail) noexcept {
  return {.cause = static_cast<Cause>(detail >> 32U), .value = static_cast<std::uint32_t>(detail)};
}

std::string WireLoss::text() const {
  const std::string number = std::to_string(value);
  switch (cause) {
    case Cause::signal: {
      const char* const name = sigdescr_np(static_cast<int>(value));
      return "ended by signal " + number + (name == nullptr ? "" : " (" + std::string(name) + ")");
    }
    case Cause::exit_code:
      return "ended with exit code " + number;
    case Cause::no_start:
      return "not ready after 10 s";
    case Cause::hangs:
      return "hung: sent nothing for 2 s";
    case Cause::deaf:
      return "deaf: no probe came through discovery and data for 4 s";
    case Cause::memory:
      return "used " + number + " MiB of memory, more than its limit";
  }
  return "gone";
}

void WireJudge::started(Time now) noexcept {
  start_ = now;
  looked_ = now;
  running_since_.reset();
}

std::optional<WireLoss> WireJudge::reason_to_end(const Sight& sight, Time now) noexcept {
  // Whoever did not look for long, because the whole service stood still, has seen no silence.
  constexpr std::chrono::milliseconds kLongestPause{500};
  if (now - std::exchange(looked_, now) > kLongestPause) {
    start_ = now;
    pumped_ = now;
    probed_ = now;
  }
  if (!sight.is_running) {
    return now - start_ > kLongestStart
               ? std::optional(WireLoss{.cause = WireLoss::Cause::no_start})
               : std::nullopt;
  }
  if (!running_since_) {
    running_since_ = now;
    pumped_ = now;
    probed_ = now;
  }
  if (std::exchange(pump_beats_, sight.pump_beats) != sight.pump_beats) {
    pumped_ = now;
  }
  if (std::exchange(probe_beats_, sight.probe_beats) != sight.probe_beats) {
    probed_ = now;
  }
  if (now - pumped_ > kLongestRound) {
    return WireLoss{.cause = WireLoss::Cause::hangs};
  }
  if (now - probed_ > kLongestProbe) {
    return WireLoss{.cause = WireLoss::Cause::deaf};
  }
  if (sight.resident > memory_limit_) {
    return WireLoss{.cause = WireLoss::Cause::memory,
                    .value = static_cast<std::uint32_t>(sight.resident / kMebi)};
  }
  return std::nullopt;
}

WireJudge::Time WireJudge::ended(Time now, bool was_judged) noexcept {
  const std::chrono::seconds long_run = was_judged ? kLongRunOfJudged : kLongRun;
  const bool was_long = running_since_ && now - *running_since_ >= long_run;
  const auto delay = was_long ? 0ms : delay_;
  delay_ = was_long ? 0ms : std::clamp(delay_ * 2, kFirstDelay, kLongestDelay);
  return now + delay;
}

}  // namespace vdrive::service
