// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"
#include "vdrive/axis.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::judge {

// Controlwords and bits that the masters of the tests use.
inline constexpr std::uint16_t kEnabled = 0x000F;
inline constexpr std::uint16_t kSetPoint = 0x001F;
inline constexpr std::uint16_t kReached = Statusword::kTargetReached;
inline constexpr std::uint16_t kAttained = Statusword::kHomingAttained;
inline constexpr std::int8_t kProfilePosition = 1;
inline constexpr std::int8_t kProfileVelocity = 3;
inline constexpr std::int8_t kHoming = 6;
inline constexpr std::int8_t kCyclicPosition = 8;

/// The information that the source of a test gives about its drive.
struct TestSource {
  SourceFacts facts{
      .has_time = true, .shows_reads = true, .shows_sessions = true, .speed_is_per_second = true};
  bool shows_mode = true;
  bool shows_error_code = true;
  std::uint64_t ticks_a_status = 1;  ///< the drive is shown every n-th tick
};

/// The drive of the core, and the judge that reads what it receives and what it shows.
class JudgedDrive {
 public:
  explicit JudgedDrive(const TestSource& source = {}, const AxisConfiguration& configuration = {},
                       std::uint32_t number = 1);

  /// One of several drives of `judge`, which must outlive the drive.
  JudgedDrive(Judge& judge, const TestSource& source, const AxisConfiguration& configuration,
              std::uint32_t number);

  // ---- actions of a master
  Fate write(ObjectAddress object, std::int64_t value, Channel channel = Channel::request,
             std::uint64_t writer = 0);
  void word(std::uint16_t word, Channel channel = Channel::request, std::uint64_t writer = 0);
  void target(std::int32_t target, Channel channel = Channel::request);
  void mode(std::int8_t mode);
  void read(ObjectAddress object);

  // ---- actions of the bench, not of a master
  void disturb(ObjectAddress object, std::int64_t value);
  void take(const decltype(Record::what)& what);

  /// From now on the drive shows this state instead of its own; nullopt = its own.
  void pretend(std::optional<PowerState> state) { pretended_ = state; }

  // ---- time
  void step(std::uint64_t ticks = 1);
  bool step_until(const std::function<bool()>& done, std::uint64_t deadline = 20'000);
  bool step_until_state(PowerState state);
  bool step_until_bits(std::uint16_t mask, std::uint16_t value, std::uint64_t deadline = 60'000);

  // ---- actions of a correct master
  void enable(std::int8_t mode);
  void disable();
  void set_point(std::int32_t target, std::uint16_t bits = 0);
  bool move(std::int32_t target, std::uint16_t bits = 0);

  // ---- what a master sees: the drive as it was last shown
  [[nodiscard]] std::uint16_t statusword() const { return shown_.ds402_statusword; }

  [[nodiscard]] std::int32_t position() const { return shown_.load_position_actual_value; }

  [[nodiscard]] const AxisStatus& status() const { return shown_; }

  [[nodiscard]] bool shows(std::uint16_t bits) const { return (statusword() & bits) == bits; }

  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  [[nodiscard]] Verdict end(bool is_over = false) { return judge_->end(is_over); }

  /// @return the names of the broken rules, in the order of their table.
  [[nodiscard]] std::vector<std::string> findings(bool is_over = false);

 private:
  void show();

  std::optional<Judge> own_;
  Judge* judge_;
  TestSource source_;
  Axis axis_;
  std::uint32_t number_;
  std::uint64_t tick_ = 0;
  std::optional<PowerState> pretended_;
  AxisStatus shown_;
};

/// @return the names of the broken rules in the order of their table, each once.
[[nodiscard]] std::vector<std::string> broken_rules(const Verdict& verdict);

}  // namespace vdrive::judge
