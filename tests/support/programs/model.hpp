// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/programs/command.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::test {

// Conditions for one axis after each tick of a random program, over any transport.

/// The invariants of an axis, as texts.
struct Invariant {
  // For the status image of any tick.
  static constexpr const char* kState = "6041h decodes to the power state";
  static constexpr const char* kReserved = "reserved bits of 6041h are 0";
  static constexpr const char* kPower = "no power outside its states";
  static constexpr const char* kTorqueOff = "no torque without power";
  static constexpr const char* kDemand = "606Bh is 0 without power";
  static constexpr const char* kErrorCode = "603Fh is set in a fault only";
  static constexpr const char* kMode = "6061h is 0 or a mode of 6502h";
  static constexpr const char* kModeBits = "bits 10 and 12 of 6041h are those of state and mode";
  // For two consecutive ticks.
  static constexpr const char* kResume = "nothing resumes by itself";
  static constexpr const char* kTransition = "without a command the state only falls";
  static constexpr const char* kReaction = "the axes of a lost master react per 6007h";
  static constexpr const char* kHoming = "bits 12 and 13 exclude each other in homing";
  static constexpr const char* kNoMotion = "no motion without power";
  static constexpr const char* kNoJump = "no position jump without cause";
  static constexpr const char* kSpeed = "607Fh and 6080h are respected";
  static constexpr const char* kRange = "607Dh is respected";
  static constexpr const char* kTorque = "6072h, 60E0h and 60E1h are respected";
  static constexpr const char* kJerk = "60A4h is respected";
  static constexpr const char* kModulo = "607Bh is respected";
  // For a command.
  static constexpr const char* kRefused = "a refused write changes nothing";
};

/// @return the first invariant of a single tick that `status` violates, or nullptr.
/// @param expected the state of the axis
/// @param maker_bits the bits of 6041h that the axis shows inverted, 5E20h:0C
[[nodiscard]] const char* violated_invariant(const AxisStatus& status, PowerState expected,
                                             std::int64_t maker_bits = 0);

/// Writes to an axis of a bank.
/// @return the abort code, and the invariant that the write violates or nullptr
[[nodiscard]] std::pair<AbortCode, const char*> write_to(AxisBank& bank, std::size_t axis,
                                                         const Write& write);

/// @return whether an axis has reacted to a lost master as 6007h requires: 0 nothing, 1 fault, 2
///         without power, 3 quick stop.
[[nodiscard]] bool reacts_to_loss(std::int64_t option, PowerState before, PowerState after);

/// The events of an axis since the previous tick.
struct AxisCauses {
  bool commanded = false;     ///< a controlword was written
  bool switched_off = false;  ///< a controlword commanded Disable voltage or Shutdown
  bool cycled = false;
  bool lost = false;  ///< its master is lost
  bool restored = false;
  bool has_test_input = false;  ///< one of 5E00h to 5E0Ah is nonzero
  bool encoder_fails = false;   ///< 5E04h
};

/// Checks the power states of one axis from tick to tick, with any settings. Only commands lead
/// upwards or out of a fault; faults, the DC link, the ends of stops and lost masters lead
/// downwards.
class PowerModel {
 public:
  /// Restarts the checks from `state`.
  void begin(PowerState state) { last_ = state; }

  /// Call for a controlword: its command may take effect in the next tick, or up to `delay` ticks
  /// later (5E20h).
  void expect_enabling(std::uint64_t delay);
  void expect_reset(std::uint64_t delay);

  /// Call when the drive has dropped such a command.
  void forget_enabling() { enabling_until_ = 0; }

  void forget_reset() { reset_until_ = 0; }

  /// @return whether such a command may take effect in the next tick.
  [[nodiscard]] bool may_enable() const { return next_tick_ <= enabling_until_; }

  [[nodiscard]] bool may_reset() const { return next_tick_ <= reset_until_; }

  /// Checks the next tick. @return the first invariant that it violates, or nullptr.
  [[nodiscard]] const char* check(const AxisStatus& now, PowerState state, bool cycled,
                                  std::int64_t maker_bits);

 private:
  std::uint64_t next_tick_ = 1;
  std::uint64_t enabling_until_ = 0;
  std::uint64_t reset_until_ = 0;
  PowerState last_ = PowerState::switch_on_disabled;
};

/// The settings of an axis, constant from power-up on.
struct AxisLimits {
  std::int64_t speed = 136'533;      ///< 607Fh, or 6080h if lower [UU/s]
  bool has_range = false;            ///< 3535h
  std::int64_t lower = 0;            ///< 607Dh:01 [UU]
  std::int64_t upper = 0;            ///< 607Dh:02 [UU]
  std::int64_t positive_torque = 0;  ///< the lower of 6072h and 60E0h [per mille]
  std::int64_t negative_torque = 0;
  int abort_connection = 1;      ///< 6007h
  double jerk = 0.0;             ///< the higher 60A4h in use [UU/s³]; 0 = not checked
  std::int64_t range_lower = 0;  ///< 607Bh:01 [UU]
  std::int64_t range_span = 0;   ///< 607Bh:02 less 607Bh:01 [UU]; 0 = no modulo axis
  bool is_pushed = false;        ///< its plant moves it without power, or seems to
  double delay = 0.0;            ///< longest delay of a controlword's effect by 5E20h [s]
  std::int64_t maker_bits = 0;   ///< 5E20h:0C
};

struct Violation {
  std::string invariant;
  std::string expected;
  std::string seen;
};

/// Checks one axis with known settings from outside: states, limits and motion.
class AxisWatch {
 public:
  AxisWatch(const AxisLimits& limits, std::chrono::microseconds period);

  /// Checks the next tick.
  /// @param state the state of the axis
  void check(const AxisStatus& now, PowerState state, const AxisCauses& causes);

  /// Restarts the checks from `now`.
  void begin(const AxisStatus& now, PowerState state);

  /// @return the first violation in any check.
  [[nodiscard]] const std::optional<Violation>& violation() const { return violation_; }

 private:
  void expect_command(std::uint64_t delay);
  void fail(const char* invariant, std::string expected, std::string seen);
  void check_jump(const AxisStatus& now, bool encoder_fails, bool commanded);
  [[nodiscard]] std::int64_t way(std::int32_t from, std::int32_t to) const;
  void check_rest(const AxisStatus& now);
  [[nodiscard]] bool brakes_at_its_limit(const AxisStatus& now) const;
  void check_speed(const AxisStatus& now);
  [[nodiscard]] bool may_be_rounded(const AxisStatus& now, const AxisCauses& causes) const;
  void check_jerk(const AxisStatus& now, const AxisCauses& causes);
  void check_range(const AxisStatus& now, bool commanded);
  void check_modulo(const AxisStatus& now);
  void check_torque(const AxisStatus& now);
  void check_homing(const AxisStatus& now, PowerState state);
  void check_reaction(const AxisStatus& now, PowerState state, const AxisCauses& causes);

  AxisLimits limits_;
  double period_s_;
  std::uint64_t delay_;  ///< [ticks]
  PowerModel power_;
  std::optional<Violation> violation_;
  AxisStatus last_;
  PowerState last_state_ = PowerState::switch_on_disabled;
  bool has_test_input_ = false;
  bool had_test_input_ = false;   ///< in the previous tick
  bool is_contained_ = false;     ///< the demand began within 607Dh and has never been led outside
  double calm_s_ = 0.0;           ///< how long nothing but the drive has moved the axis
  std::int64_t rest_speed_ = -1;  ///< highest speed allowed without power; negative = any
  std::int64_t last_change_ = 0;  ///< of 606Bh in the previous tick [UU/s]
  int standing_ticks_ = 0;        ///< how long the demand of a profile has been at rest
  bool is_rounded_ = false;       ///< since that rest, only profiles have led the demand
};

}  // namespace vdrive::test
