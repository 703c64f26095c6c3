// SPDX-License-Identifier: Apache-2.0
#include "engine/master_watch.hpp"

#include <algorithm>

namespace vdrive::service {

MasterWatch::MasterWatch(const Configuration& configuration, const BenchClock& clock,
                         Masters& masters, Counters& counters)
    : clock_(clock),
      masters_(masters),
      counters_(counters),
      period_(configuration.period),
      watchdog_(effective_watchdog(configuration)),
      ticks_(patience()) {}

void MasterWatch::watch() {
  if (ticks_ == 0) return;
  for (auto& record : masters_.sessions()) {
    if (record.owned_axes == 0) continue;
    const std::uint64_t silence = clock_.tick() - record.last_message_tick;
    if (silence > longest_silence_) {
      longest_silence_ = silence;
      counters_.longest_silence_us.set(static_cast<std::uint64_t>(time_of(silence).count()));
    }
    if (silence > ticks_) {
      masters_.lose(record, std::chrono::floor<std::chrono::milliseconds>(time_of(silence)));
    }
  }
}

void MasterWatch::follow_rate() {
  ticks_ = patience();
  for (auto& record : masters_.sessions()) record.last_message_tick = clock_.tick();
}

void MasterWatch::skip(std::uint64_t ticks) {
  for (auto& record : masters_.sessions()) record.last_message_tick += ticks;
}

std::chrono::microseconds MasterWatch::time_of(std::uint64_t ticks) const noexcept {
  return period_ * static_cast<std::int64_t>(ticks);
}

std::uint64_t MasterWatch::patience() const noexcept {
  if (!watchdog_) return 0;
  return clock_.ticks_in(std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::duration<double, std::milli>(*watchdog_) * std::max(clock_.rate(), 1.0)));
}

}  // namespace vdrive::service
