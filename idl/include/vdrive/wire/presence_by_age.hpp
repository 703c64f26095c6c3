// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/presence.hpp"
#include "vdrive/wire/source.hpp"

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::wire {

/// Presence judged by the age of samples, on networks where nothing shows for certain who exists. A
/// gap between two calls of own_pauses that exceeds kLongestGap counts as a pause of this program:
/// it was stopped, or the machine was busy.
class PresenceByAge final : public Presence {
 public:
  static constexpr std::chrono::milliseconds kPulse{50};
  /// Three pulses: a busy machine is often late, but by less than this.
  static constexpr std::chrono::milliseconds kLongestGap{150};
  /// Time that others need to find this program again after they have removed it: about 0.1 s,
  /// longer on a busy machine.
  static constexpr std::chrono::milliseconds kTimeToBeFoundAgain{500};

  using Named = std::function<std::vector<OtherParticipant>(std::string_view beginning)>;

  /// @param others returns those known now
  explicit PresenceByAge(Named others) : others_(std::move(others)) {}

  [[nodiscard]] std::vector<OtherParticipant> others(std::string_view beginning) const override {
    return others_(beginning);
  }

  [[nodiscard]] bool may_miss_some() const noexcept override { return true; }

  [[nodiscard]] bool is_certain(const Source& /*source*/) const noexcept override { return false; }

  [[nodiscard]] bool may_have_double() const noexcept override { return true; }

  /// Always true: a service may restart.
  [[nodiscard]] bool may_return() const noexcept override { return true; }

  [[nodiscard]] Clock::duration own_pauses(Clock::time_point now) override;

  [[nodiscard]] std::optional<std::chrono::milliseconds> pulse() const noexcept override {
    return kPulse;
  }

  [[nodiscard]] std::optional<Clock::duration> silence(
      const Source& source, std::optional<Clock::time_point> newest_sample,
      Clock::time_point now) const noexcept override;

  [[nodiscard]] bool is_excused(Clock::time_point now) const override;

 private:
  Named others_;
  mutable std::mutex mutex_;                 ///< guards the members below
  std::optional<Clock::time_point> newest_;  ///< last call of own_pauses
  Clock::duration pauses_{};
  std::optional<Clock::time_point> excused_until_;
};

}  // namespace vdrive::wire
