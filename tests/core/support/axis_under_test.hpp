// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <chrono>
#include <concepts>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdrive::test {

/// Default resolution of an axis's encoders [UU/rad].
inline constexpr double kUnitsPerRadian = 4096.0 / (2.0 * std::numbers::pi);

/// One axis whose objects are accessed by variable_name, and its clock. A refused write or read
/// throws, which fails the test; try_write and try_read give the abort code.
class AxisUnderTest {
 public:
  static constexpr std::chrono::microseconds kDefaultPeriod{1000};

  explicit AxisUnderTest(const AxisConfiguration& configuration = {},
                         std::chrono::microseconds period = kDefaultPeriod)
      : axis_(configuration, period), period_(period) {}

  static ObjectAddress address_of(std::string_view variable_name) {
    const auto row = find_object(variable_name);
    if (!row) throw std::logic_error("no object is called " + std::string(variable_name));
    return describe(*row).address;
  }

  AbortCode try_write(std::string_view variable_name, std::int64_t value) {
    return axis_.write(address_of(variable_name), value);
  }

  void write(std::string_view variable_name, std::int64_t value) {
    const AbortCode code = try_write(variable_name, value);
    if (code != AbortCode::none) {
      throw std::logic_error(std::string(variable_name) + " = " + std::to_string(value) +
                             " refused: " + std::string(describe(code)));
    }
  }

  [[nodiscard]] ReadResult try_read(std::string_view variable_name) const {
    return axis_.read(address_of(variable_name));
  }

  [[nodiscard]] std::int64_t read(std::string_view variable_name) const {
    const ReadResult result = try_read(variable_name);
    if (result.code != AbortCode::none) {
      throw std::logic_error(std::string(variable_name) + ": " +
                             std::string(describe(result.code)));
    }
    return result.value;
  }

  /// Writes 6040h; takes effect in the next step.
  void controlword(std::uint16_t word) { write("ds402_controlword", word); }

  /// Writes 6040h and runs one tick. @return the statusword after it.
  std::uint16_t command(std::uint16_t word) {
    controlword(word);
    return step();
  }

  /// Runs ticks. @return the statusword after the last.
  std::uint16_t step(std::uint64_t ticks = 1) {
    for (std::uint64_t i = 0; i < ticks; ++i) {
      axis_.step();
      ++ticks_;
    }
    return statusword();
  }

  void step_for(std::chrono::microseconds time) {
    step(static_cast<std::uint64_t>(time.count() / period_.count()));
  }

  /// Steps until `done()` holds after a tick.
  /// @return the number of ticks that it took; 0 if `deadline` ticks were not enough.
  template <std::predicate Predicate>
  std::uint64_t step_until(Predicate done, std::uint64_t deadline) {
    for (std::uint64_t ticks = 1; ticks <= deadline; ++ticks) {
      step();
      if (done()) return ticks;
    }
    return 0;
  }

  /// Steps until all bits of `mask` in the statusword equal `value`; see above.
  std::uint64_t step_until_status(std::uint16_t mask, std::uint16_t value, std::uint64_t deadline) {
    return step_until(
        [this, mask, value] {
          return (statusword() & mask) == value;
        },
        deadline);
  }

  /// Steps until bit 10 is 1; see above.
  std::uint64_t step_until_reached(std::uint64_t deadline) {
    return step_until_status(Statusword::kTargetReached, Statusword::kTargetReached, deadline);
  }

  /// Steps until the statusword shows `state`; see above.
  std::uint64_t step_until_state(PowerState state, std::uint64_t deadline) {
    return step_until(
        [this, state] {
          return this->state() == state;
        },
        deadline);
  }

  /// Profile position mode, Operation enabled, at rest.
  void enable() {
    write("op_mode_cmd", 1);
    command(0x000F);
  }

  [[nodiscard]] std::uint16_t statusword() const { return status().ds402_statusword; }

  [[nodiscard]] const AxisStatus& status() const { return axis_.status(); }

  [[nodiscard]] PowerState state() const { return decode_power_state(statusword()); }

  [[nodiscard]] std::int32_t demand() const { return status().position_demand_value; }

  [[nodiscard]] std::int32_t actual() const { return status().load_position_actual_value; }

  [[nodiscard]] std::int32_t demand_velocity() const { return status().velocity_demand_value; }

  [[nodiscard]] std::int32_t velocity() const { return status().load_velocity_actual_value; }

  [[nodiscard]] bool reached() const { return (statusword() & Statusword::kTargetReached) != 0; }

  [[nodiscard]] bool acknowledged() const {
    return (statusword() & Statusword::kSetPointAcknowledge) != 0;
  }

  /// Bit 12 in the cyclic modes.
  [[nodiscard]] bool follows_command() const {
    return (statusword() & Statusword::kFollowsCommand) != 0;
  }

  /// Bit 12 in interpolated position mode.
  [[nodiscard]] bool interpolates() const {
    return (statusword() & Statusword::kInterpolationActive) != 0;
  }

  [[nodiscard]] bool limit_active() const {
    return (statusword() & Statusword::kInternalLimitActive) != 0;
  }

  /// Ticks stepped so far.
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

  [[nodiscard]] double seconds_per_tick() const {
    return static_cast<double>(period_.count()) * 1.0e-6;
  }

  [[nodiscard]] Axis& axis() { return axis_; }

 private:
  Axis axis_;
  std::chrono::microseconds period_;
  std::uint64_t ticks_ = 0;
};

}  // namespace vdrive::test
