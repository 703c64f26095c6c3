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
/// and sends the bench keep-alives. Time is passed as an argument. For one thread.
class BenchPower {
 public:
  using Clock = std::chrono::steady_clock;
  using Frames = std::vector<client::SetPointFrame>;

  /// @param session that commands the axes
  /// @param bench must outlive this, like `reports`
  BenchPower(std::uint64_t session, Bench& bench, bridge::Reports& reports);

  /// Takes control and enables all axes, or disables those that it has enabled.
  /// @param resets_faults also enables axes in a fault, once
  void want_enabled(bool wanted, bool resets_faults);

  [[nodiscard]] bool wants_enabled() const noexcept { return wants_enabled_; }

  /// @return whether no axis held by the session is enabled, or about to be by controlwords in
  ///         flight.
  [[nodiscard]] bool is_disabled(const client::Observation& state) const;

  /// Reports axes that have gone into a fault since the last call.
  void report_faults(const client::Observation& state);

  /// @return the controlwords that are due, in order.
  [[nodiscard]] Frames words(const client::Observation& state, Clock::time_point now);

  /// @return whether the bench needs a keep-alive now. Only in lock-step: otherwise those of the
  ///         session are enough.
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
  bool has_to_give_back_ = false;  ///< release the axes once none of them is enabled
  /// While wants_enabled_: axes that have not been enabled since it was set. Afterwards: axes for
  /// which controlwords to enable them may still be in flight.
  std::vector<bool> to_enable_;
  std::vector<bool> was_in_fault_;
  int attempts_ = 0;
  Clock::time_point words_due_{};
  std::uint64_t words_tick_ = 0;
  std::uint64_t kept_alive_at_ = 0;  ///< tick of the last keep-alive
};

}  // namespace vdrive::ros2
