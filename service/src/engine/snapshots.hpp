// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/reason.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/bench_output.hpp"
#include "engine/frame_schedule.hpp"
#include "engine/masters.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdrive::service {

/// Saved states of all axes, taken and restored by request. A restore brings back the state, but
/// not the time. Each function returns REASON_NONE, or why the request is refused.
class Snapshots {
 public:
  /// A limit is needed because each snapshot holds the state of all axes, and a client might never
  /// drop one.
  static constexpr std::size_t kMost = msg::MAX_SNAPSHOTS;

  Snapshots(BenchAxes& axes, const BenchClock& clock, const Masters& masters,
            FrameSchedule& schedule, BenchOutput& output, BenchEvents& events, Counters& counters);

  /// Allocates, as does `restore`. That is harmless: time stands still, so no tick is due.
  [[nodiscard]] Reason take(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] Reason restore(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] Reason drop(const msg::Request& request, msg::Reply& reply);

  /// Returns the first kept snapshot after the one in the request, and the tick it was taken in.
  [[nodiscard]] Reason show_next(const msg::Request& request, msg::Reply& reply) const;

 private:
  struct Kept {
    std::uint64_t number = 0;
    std::uint64_t tick = 0;  ///< when it was taken
    std::shared_ptr<const AxisBank::Snapshot> state;
  };

  [[nodiscard]] Reason check_owners(const msg::Request& request, msg::Reply& reply) const;
  void report(const msg::Request& request, std::uint32_t code, std::uint64_t number);

  BenchAxes& axes_;
  const BenchClock& clock_;
  const Masters& masters_;
  FrameSchedule& schedule_;
  BenchOutput& output_;
  BenchEvents& events_;
  Counters& counters_;
  std::vector<Kept> kept_;  ///< by number
  std::uint64_t last_number_ = 0;
};

}  // namespace vdrive::service
