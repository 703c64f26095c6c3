// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/record.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/object.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::judge {

/// Objects by name, as the rules refer to them.
namespace objects {
inline constexpr ObjectAddress kStore{0x1010, 1};
inline constexpr ObjectAddress kErrorField{0x1003, 1};
inline constexpr ObjectAddress kErrorCode{0x603F, 0};
inline constexpr ObjectAddress kControlword{0x6040, 0};
inline constexpr ObjectAddress kStatusword{0x6041, 0};
inline constexpr ObjectAddress kVelocityModeTarget{0x6042, 0};
inline constexpr ObjectAddress kShutdownOption{0x605B, 0};
inline constexpr ObjectAddress kMode{0x6060, 0};
inline constexpr ObjectAddress kModeShown{0x6061, 0};
inline constexpr ObjectAddress kPositionDemand{0x6062, 0};
inline constexpr ObjectAddress kPosition{0x6064, 0};
inline constexpr ObjectAddress kFollowingWindow{0x6065, 0};
inline constexpr ObjectAddress kTargetTorque{0x6071, 0};
inline constexpr ObjectAddress kMaxTorque{0x6072, 0};
inline constexpr ObjectAddress kTorque{0x6077, 0};
inline constexpr ObjectAddress kTarget{0x607A, 0};
inline constexpr ObjectAddress kLowerLimit{0x607D, 1};
inline constexpr ObjectAddress kUpperLimit{0x607D, 2};
inline constexpr ObjectAddress kSpeedLimit{0x607F, 0};
inline constexpr ObjectAddress kProfileVelocity{0x6081, 0};
inline constexpr ObjectAddress kInterpolationRecord{0x60C1, 1};
inline constexpr ObjectAddress kCyclePeriod{0x60C2, 1};
inline constexpr ObjectAddress kCycleIndex{0x60C2, 2};
inline constexpr ObjectAddress kAccelerationLimit{0x60C5, 0};
inline constexpr ObjectAddress kFollowingError{0x60F4, 0};
inline constexpr ObjectAddress kTargetVelocity{0x60FF, 0};
inline constexpr ObjectAddress kMotorSpeedLimit{0x5E11, 0};  ///< 6080h in user units, of vdrive
}  // namespace objects

/// In Ready to switch on, Enable operation passes through Switched on (transitions 3 and 4). In
/// Quick stop active it does nothing: transition 16 is optional.
/// @return the state that `command` leads to; `state` if there is no transition.
[[nodiscard]] PowerState state_after(PowerState state, PowerCommand command) noexcept;

/// Known values of objects, by address.
class KnownValues {
 public:
  /// Further values are dropped; those that the rules need are among the first.
  static constexpr std::size_t kMost = 512;

  void set(ObjectAddress object, std::int64_t value);
  [[nodiscard]] std::optional<std::int64_t> find(ObjectAddress object) const noexcept;

 private:
  std::vector<std::pair<ObjectAddress, std::int64_t>> values_;  ///< sorted
};

/// An older position says nothing about the present one.
inline constexpr Time kFreshPosition{std::chrono::milliseconds(100)};

/// Smaller changes are not jumps [user units].
inline constexpr std::int64_t kSmallJump = 100;

/// The event that the master appears to be waiting for.
enum class Waiting : std::uint8_t {
  nothing,
  switch_on_disabled,
  ready_to_switch_on,
  switched_on,
  operation_enabled,
  quick_stop,
  mode,
  acknowledge,
  acknowledge_gone,
  arrival,
  homing,
};

/// The known state of one axis: the commands of the master, and the last state shown by the drive.
/// Nothing is guessed; anything not seen is absent.
struct AxisTrack {
  // ---- the drive
  bool has_status = false;        ///< 6041h was shown since the last gap or restart
  bool is_status_pushed = false;  ///< the drive sends every change of it unasked
  std::uint16_t statusword = 0;
  PowerState state = PowerState::not_ready_to_switch_on;
  PowerState state_before = PowerState::not_ready_to_switch_on;  ///< in the previous status
  Time status_time{};
  Time state_since{};
  std::optional<std::int8_t> mode_shown;
  bool is_mode_pushed = false;
  Time mode_shown_time{};
  Time mode_since{};  ///< since when the mode shown has not changed
  std::optional<std::int32_t> position;
  Time position_time{};
  std::optional<std::int32_t> demand;
  std::optional<std::int32_t> following_error;
  std::optional<std::int16_t> torque;
  std::uint16_t error_code = 0;
  std::optional<NodeState> node_state;
  std::optional<Time> started;           ///< by the NMT master; none once another state follows
  std::optional<Time> left_operational;  ///< reset when it is Operational again

  // ---- the master
  bool has_controlword = false;
  std::uint16_t controlword = 0;
  Time controlword_time{};
  PowerCommand command = PowerCommand::none;  ///< the last command
  /// The state to which the commands lead: the state shown, until a command leads to another one.
  PowerState expected = PowerState::not_ready_to_switch_on;
  std::optional<std::int8_t> mode_wanted;
  Time mode_wanted_time{};
  std::optional<std::int32_t> target;  ///< 607Ah
  Time target_time{};
  KnownValues values;

  std::uint32_t facts = 0;  ///< the facts seen so far

  void apply(const Write& write, Time now);
  void apply(const Shown& shown, Time now);
  void apply(const Reading& reading);

  /// @return whether the state has changed.
  bool apply(const Network& network, Time now);

  /// Called when states may have changed unseen.
  void forget();

  /// Called when the drive was restarted: the present values of its objects are unknown.
  void restart();

  /// @return the mode in 6061h or, if it was not shown since 6060h was written, the mode in 6060h.
  [[nodiscard]] std::optional<std::int8_t> mode_in_force() const noexcept;

  [[nodiscard]] bool is_in(OperatingMode mode) const noexcept {
    return mode_in_force() == static_cast<std::int8_t>(mode);
  }

  /// @return whether the mode in force is cyclic, 7 to 10.
  [[nodiscard]] bool is_cyclic() const noexcept;

  [[nodiscard]] bool is_enabled() const noexcept {
    return has_status && state == PowerState::operation_enabled;
  }

  [[nodiscard]] bool shows(std::uint16_t bits) const noexcept {
    return has_status && (statusword & bits) == bits;
  }

  [[nodiscard]] bool commands(std::uint16_t bits) const noexcept {
    return (controlword & bits) == bits;
  }

  /// @return whether the axis is certainly moving: its last positions went in one direction,
  ///         further than noise or settling would take it, not long ago, and no bit of the
  ///         statusword indicates standstill.
  [[nodiscard]] bool is_moving(Time now) const noexcept;

  /// @return whether the axis is at `place`, or was there at one of its last positions.
  [[nodiscard]] bool is_near(std::int64_t place) const noexcept;

  [[nodiscard]] Waiting waiting() const noexcept;

 private:
  void apply_statusword(const Shown& shown, Time now);
  void note_position(std::int32_t now_at, Time now);
  [[nodiscard]] Waiting waiting_in_homing() const noexcept;
  [[nodiscard]] Waiting waiting_for_set_point() const noexcept;
  void note_value(ObjectAddress object, std::int64_t value);

  static constexpr std::size_t kSteps = 3;

  std::array<std::int64_t, kSteps> steps_{};  ///< differences of the last positions
  std::int32_t lowest_ = 0;                   ///< position since the last gap or restart
  std::int32_t highest_ = 0;                  ///< position since the last gap or restart
};

/// @return whether the drive took the value of `write`: it was neither refused nor late.
[[nodiscard]] inline bool is_taken(const Write& write) noexcept {
  return write.fate == Fate::accepted || write.fate == Fate::unanswered ||
         write.fate == Fate::ignored;
}

}  // namespace vdrive::judge
