// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_bank.hpp"

#include <span>

namespace vdrive {

/// One axis: an AxisBank of size one, for programs that embed a single drive.
class Axis {
 public:
  /// @throws std::invalid_argument as AxisBank does.
  Axis(const AxisConfiguration& configuration, std::chrono::microseconds period)
      : bank_(std::span(&configuration, 1), period) {}

  AbortCode write(ObjectAddress object, std::int64_t value) noexcept {
    return bank_.write(0, object, value);
  }

  [[nodiscard]] ReadResult read(ObjectAddress object) const noexcept {
    return bank_.read(0, object);
  }

  void step() noexcept { bank_.step(); }

  [[nodiscard]] const AxisStatus& status() const noexcept { return bank_.status(0); }

  [[nodiscard]] PowerState power_state() const noexcept { return bank_.power_state(0); }

  void power_cycle() noexcept { bank_.power_cycle(0); }

  AbortCode set_stored(ObjectAddress object, std::int64_t value) noexcept {
    return bank_.set_stored(0, object, value);
  }

  void forget_stored() noexcept { bank_.forget_stored(0); }

  void report_connection_loss() noexcept { bank_.report_connection_loss(0); }

 private:
  AxisBank bank_;
};

}  // namespace vdrive
