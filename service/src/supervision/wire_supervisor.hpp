// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "seam/queues.hpp"
#include "seam/wire_region.hpp"
#include "supervision/wire_judge.hpp"
#include "supervision/wire_spawner.hpp"

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace vdrive::service {

/// Keeps a wire running in a separate process. Used by one thread at a time, which calls
/// supervise() every few milliseconds.
class WireSupervisor {
 public:
  /// @param region, spawner, counters outlive this
  WireSupervisor(const WireRegion& region, WireSpawner& spawner, std::uint64_t memory_limit,
                 Counters& counters);

  /// Starts the first wire and waits until it runs.
  /// @throws wire::NetworkError if it cannot start, with the reason that it gave
  void start();

  /// Judges the wire, ends it if necessary, and starts the next one.
  void supervise();

  /// @return the oldest unreported event, without its tick, or nullopt.
  std::optional<EventRecord> next_news();

  /// @return whether no wire can be started any more: the spawner is gone.
  [[nodiscard]] bool is_cut_off() const noexcept { return spawner_.is_gone(); }

  /// Ends the wire with the bench: first lets it send what is queued and announce its end, for
  /// `patience` at most.
  void stop(std::chrono::milliseconds patience) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  void launch(Clock::time_point now);
  void report(std::uint32_t code, const EventDetail& detail);
  void lose(const WireLoss& loss, Clock::time_point now);
  void finish(const WireEnd& end, Clock::time_point now);
  void judge(Clock::time_point now);

  const WireRegion& region_;
  WireControl& control_;
  WireSpawner& spawner_;
  WireJudge judge_;
  Counters& counters_;
  std::uint32_t generation_ = 0;
  bool is_launched_ = false;
  bool is_up_ = false;
  std::optional<WireLoss> reason_;  ///< why the wire was killed
  std::optional<Clock::time_point> next_start_;
  Clock::time_point lost_at_{};
  std::deque<EventRecord> news_;
};

}  // namespace vdrive::service
