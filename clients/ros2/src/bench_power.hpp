// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "reports.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::ros2 {

/// Enables the axes of a bench in the modes of their joints, disables those that it has enabled,
/// and keeps the bench informed that their master lives. Time is an argument. For one thread.
class BenchPower {
 public:
  using Clock = std::chrono::steady_clock;
  using Frames = std::vector<client::SetPointFrame>;

  /// @param session that commands the axes
  /// @param bench outlives this, as `reports` does
  BenchPower(std::uint64_t session, Bench& bench, bridge::Reports& reports);

  /// Takes control and enables all axes, or disables those that it has enabled.
  /// @param resets_faults also of axes in a fault, once
  void want_enabled(bool wanted, bool resets_faults);

  [[nodiscard]] bool wants_enabled() const noexcept { return wants_enabled_; }

  /// @return whether no axis that the session holds is enabled, or about to be by words that were
  ///         sent.
  [[nodiscard]] bool is_disabled(const client::Observation& state) const;

  /// Reports axes that have got into a fault since the last call.
  void report_faults(const client::Observation& state);

  /// @return the words that are due, in this order.
  [[nodiscard]] Frames words(const client::Observation& state, Clock::time_point now);

  /// @return whether the bench has to hear from its master now: in realtime the session does that
  ///         itself.
  [[nodiscard]] bool is_keep_alive_due(const client::Observation& state);

 private:
  [[nodiscard]] Frames enable(const client::Observation& state, Clock::time_point now);
  void put_mode(std::size_t place, client::SetPoint& last) const;
  [[nodiscard]] Frames disable(const client::Observation& state);
  void forget_old_words(const client::Observation& state, Clock::time_point now);

  const std::uint64_t session_;
  Bench& bench_;
  bridge::Reports& reports_;
  bool wants_enabled_ = false;
  bool resets_faults_ = false;
  bool has_to_give_back_ = false;  ///< the axes, once none of them is enabled
  /// Axes that have not been enabled since it was wanted; when it is wanted no more, those to which
  /// words are on their way.
  std::vector<bool> to_enable_;
  std::vector<bool> was_in_fault_;
  int attempts_ = 0;
  Clock::time_point words_due_{};
  std::uint64_t words_tick_ = 0;
  std::uint64_t kept_alive_at_ = 0;  ///< tick of the last keep-alive
};

}  // namespace vdrive::ros2
