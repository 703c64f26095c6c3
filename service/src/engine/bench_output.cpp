// SPDX-License-Identifier: Apache-2.0
#include "engine/bench_output.hpp"

#include "vdrive/wire/conversion.hpp"

#include <algorithm>
#include <span>

namespace vdrive::service {
namespace {

// After a restore all axes have changed; each tick sends a part of them, so that no tick is late.
constexpr std::size_t kParametersPerTick = 16;

}  // namespace

BenchOutput::BenchOutput(const BenchIdentity& identity, const BenchClock& clock, BenchAxes& axes,
                         const Masters& masters, BenchEvents& events, Outbox& outbox,
                         Counters& counters)
    : identity_(identity),
      clock_(clock),
      axes_(axes),
      masters_(masters),
      events_(events),
      outbox_(outbox),
      counters_(counters) {}

void BenchOutput::queue_status(bool repeated) {
  StatusImage* const image = outbox_.status.free_slot();
  if (image == nullptr) {
    counters_.queue_overflows.add();
    counters_.status_images_lost.add();
    return;
  }
  image->tick = clock_.tick();
  image->skipped = clock_.skipped();
  image->repeated = repeated;
  axes_.share(axes_.size(), [&](std::size_t first, std::size_t last) {
    const std::size_t count = last - first;
    std::ranges::copy(axes_.bank().statuses().subspan(first, count), &image->status[first]);
    std::ranges::copy(std::span(masters_.owners()).subspan(first, count), &image->owners[first]);
  });
  outbox_.status.push();
}

void BenchOutput::queue_changes() {
  events_.report_overflows();
  report_journal();
  ChangedAxes& changed = axes_.changed();
  for (std::size_t count = 0; count < kParametersPerTick && !changed.empty(); ++count) {
    msg::AxisParameters* const slot = outbox_.parameters.free_slot();
    if (slot == nullptr) return;  // the axes stay marked, and are sent with their latest values
    const std::size_t axis = changed.take();
    wire::to_message(axes_.bank(), axis, {identity_.bench, axes_.number_of(axis)}, clock_.tick(),
                     *slot);
    outbox_.parameters.push();
  }
}

void BenchOutput::report_journal() {
  while (events_.has_room()) {
    const auto news = axes_.next_journal_news();
    if (!news) return;
    events_.report({.kind = msg::EventKind::journal, .code = news->code, .detail = news->detail});
  }
}

}  // namespace vdrive::service
