// SPDX-License-Identifier: Apache-2.0
#include "supervision/wire_judge.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kBytesOfMebibyte = 1'024ULL * 1'024ULL;

}  // namespace

void WireJudge::note_start(Time now) noexcept {
  start_ = now;
  judged_ = now;
  running_since_.reset();
}

std::optional<WireLoss> WireJudge::reason_to_end(const Health& health, Time now) noexcept {
  // If the judge was not called for a while because the service itself was paused, that time does
  // not count as silence of the wire.
  constexpr std::chrono::milliseconds kLongestPause{500};
  if (now - std::exchange(judged_, now) > kLongestPause) {
    start_ = now;
    pumped_ = now;
    probed_ = now;
  }
  if (!health.is_running) {
    return now - start_ > kLongestStart
               ? std::optional(WireLoss{.cause = WireLoss::Cause::no_start})
               : std::nullopt;
  }
  if (!running_since_) {
    running_since_ = now;
    pumped_ = now;
    probed_ = now;
  }
  if (std::exchange(pump_beats_, health.pump_beats) != health.pump_beats) pumped_ = now;
  if (std::exchange(probe_beats_, health.probe_beats) != health.probe_beats) probed_ = now;
  if (now - pumped_ > kLongestRound) return WireLoss{.cause = WireLoss::Cause::hangs};
  if (now - probed_ > kLongestProbe) return WireLoss{.cause = WireLoss::Cause::deaf};
  if (health.resident > memory_limit_) {
    return WireLoss{.cause = WireLoss::Cause::memory,
                    .value = static_cast<std::uint32_t>(health.resident / kBytesOfMebibyte)};
  }
  return std::nullopt;
}

bool WireJudge::needs_examination(Time now) noexcept {
  const Time heard = running_since_ ? pumped_ : start_;
  if (now - std::max(heard, examined_) <= kLateRound) return false;
  examined_ = now;
  return true;
}

WireJudge::Time WireJudge::note_end(Time now, bool was_judged) noexcept {
  const std::chrono::seconds long_run = was_judged ? kLongRunOfJudged : kLongRun;
  const bool was_long = running_since_ && now - *running_since_ >= long_run;
  const auto delay = was_long ? 0ms : delay_;
  delay_ = was_long ? 0ms : std::clamp(delay_ * 2, kFirstDelay, kLongestDelay);
  return now + delay;
}

}  // namespace vdrive::service
