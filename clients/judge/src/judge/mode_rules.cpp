// SPDX-License-Identifier: Apache-2.0
#include "judge/mode_rules.hpp"

#include "judge/words.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;

constexpr Time kAgainTime = 10s;
constexpr std::size_t kAgainWrites = 3;
constexpr std::uint32_t kForeignWrites = 5;
constexpr Time kPulse = 500ms;  ///< a start that is cleared sooner was meant as a pulse
constexpr Time kSilentHoming = 100ms;
constexpr Time kNeverStarted = 1s;

struct TargetRow {
  ObjectAddress object;
  std::array<OperatingMode, 3> modes{};
};

constexpr std::array kTargets{
    TargetRow{objects::kTarget,
              {OperatingMode::profile_position, OperatingMode::interpolated_position,
               OperatingMode::cyclic_synchronous_position}},
    TargetRow{objects::kInterpolationRecord,
              {OperatingMode::interpolated_position, OperatingMode::interpolated_position,
               OperatingMode::interpolated_position}},
    TargetRow{objects::kTargetVelocity,
              {OperatingMode::profile_velocity, OperatingMode::cyclic_synchronous_velocity,
               OperatingMode::cyclic_synchronous_velocity}},
    TargetRow{objects::kTargetTorque,
              {OperatingMode::profile_torque, OperatingMode::cyclic_synchronous_torque,
               OperatingMode::cyclic_synchronous_torque}},
    TargetRow{objects::kVelocityModeTarget,
              {OperatingMode::velocity, OperatingMode::velocity, OperatingMode::velocity}},
};

bool is_of_mode(const TargetRow& row, std::int8_t mode) {
  return std::ranges::find(row.modes, static_cast<OperatingMode>(mode)) != row.modes.end();
}

/// @return whether bit 4 starts an action in this mode.
bool starts_by_bit_4(std::int8_t mode) {
  return mode == static_cast<std::int8_t>(OperatingMode::profile_position) ||
         mode == static_cast<std::int8_t>(OperatingMode::homing) ||
         mode == static_cast<std::int8_t>(OperatingMode::interpolated_position);
}

/// A rising edge of bit 4 in Operation enabled.
void judge_start(const Context& context) {
  const AxisTrack& track = context.track;
  if (!track.mode_wanted || !starts_by_bit_4(*track.mode_wanted)) return;
  const bool is_current =
      track.mode_shown && (track.is_mode_pushed || track.mode_shown_time >= track.mode_wanted_time);
  if (is_current) {
    if (*track.mode_shown == *track.mode_wanted) return;
    return context.report(Rule::mode_not_in_force, [&] {
      return "bit 4 rose for mode " + std::to_string(*track.mode_wanted) + " while 6061h showed " +
             mode_text(*track.mode_shown);
    });
  }
  if ((track.facts & Fact::kReads) == 0) return;
  context.report(Rule::mode_not_looked_at, [&] {
    return "bit 4 rose " + duration_text(context.now() - track.mode_wanted_time) +
           " after 6060h = " + std::to_string(*track.mode_wanted) + ", without reading 6061h";
  });
}

constexpr std::uint16_t kHomingEnded = Statusword::kHomingAttained | Statusword::kHomingError;

bool is_homing_running(const AxisTrack& track) {
  return track.is_enabled() && track.is_in(OperatingMode::homing) &&
         (track.statusword & (kHomingEnded | Statusword::kTargetReached)) == 0;
}

/// @return whether a controlword interrupts homing: it clears bit 4 or removes the power. A quick
///         stop and a halt do so on purpose and do not count.
bool ends_homing(std::uint16_t word, const AxisTrack& track) {
  const PowerCommand decoded = decode_command(word, track.controlword);
  if (decoded == PowerCommand::quick_stop || (word & Controlword::kHalt) != 0) return false;
  const bool loses_power =
      decoded == PowerCommand::disable_voltage || decoded == PowerCommand::shutdown;
  const bool drops_start =
      track.commands(Controlword::kStartHoming) && (word & Controlword::kStartHoming) == 0;
  return loses_power || drops_start;
}

}  // namespace

void ModeRules::forget() {
  *this = {};
}

void ModeRules::take(const Write& write, const Context& context) {
  if (write.object == objects::kMode) {
    take_mode(write, context);
  } else if (write.object == objects::kControlword && is_taken(write)) {
    take_word(write, context);
  } else if (is_taken(write)) {
    take_target(write, context);
  }
}

void ModeRules::take_mode(const Write& write, const Context& context) {
  const AxisTrack& track = context.track;
  const auto mode = static_cast<std::int8_t>(write.value);
  const bool is_again = track.mode_shown == mode && write.channel != Channel::pdo &&
                        (track.mode_wanted == mode || write.fate == Fate::refused);
  if (is_again) note_again(write, context);
  if (!is_taken(write) || track.mode_in_force() == mode) return;
  foreign_writes_ = 0;
  if (is_homing_running(track) || is_homing_unseen(context)) return leave_homing(context);
  if (!track.is_enabled() || !track.mode_in_force()) return;
  const bool is_moving = track.is_moving(context.now());
  if (!is_moving && !track.commands(Controlword::kHalt)) return;
  context.report(Rule::mode_changed_in_motion, [&] {
    return "6060h = " + std::to_string(mode) +
           (is_moving ? " while the axis moved in " : " while bit 8 (halt) was up in ") +
           mode_text(*track.mode_in_force());
  });
}

void ModeRules::note_again(const Write& write, const Context& context) {
  while (!again_.empty() && context.now() - again_.front() > kAgainTime) again_.pop_front();
  again_.push_back(context.now());
  if (again_.size() < kAgainWrites) return;
  again_.clear();
  context.report(Rule::mode_written_again, [&] {
    return "6060h = " + std::to_string(write.value) + " came " + std::to_string(kAgainWrites) +
           " times within 10 s while 6061h showed it" +
           (write.fate == Fate::refused ? "; the drive refused it" : "");
  });
}

void ModeRules::take_word(const Write& write, const Context& context) {
  const AxisTrack& track = context.track;
  const auto word = static_cast<std::uint16_t>(write.value);
  const bool is_up = (word & Controlword::kNewSetPoint) != 0;
  const bool was_up = track.commands(Controlword::kNewSetPoint);
  if (!track.is_enabled()) return;
  if (is_up && !was_up && track.has_controlword) judge_start(context);
  if (!track.is_in(OperatingMode::homing)) return;
  if (is_homing_running(track) && homing_start_ && ends_homing(word, track)) leave_homing(context);
  if (was_up && !is_up && is_homing_unseen(context)) leave_homing(context);
  if (is_up && was_up) stay_in_homing(write, context);
  if (!is_up || was_up || !track.has_controlword) return;
  homing_start_ = context.now();
  was_attained_at_start_ = track.shows(Statusword::kHomingAttained);
  is_homing_shown_ = false;
}

bool ModeRules::is_homing_unseen(const Context& context) const noexcept {
  if (!homing_start_ || is_homing_shown_ || !was_attained_at_start_) return false;
  // A homing that completes immediately changes no bit, so a drive that sends changes has nothing
  // to send.
  return !context.track.is_status_pushed || context.now() - *homing_start_ <= kSilentHoming;
}

void ModeRules::leave_homing(const Context& context) {
  if (!homing_start_) return;
  const Time since = context.now() - *homing_start_;
  homing_start_.reset();
  if (!is_homing_shown_ && was_attained_at_start_) {
    return context.report(Rule::homing_judged_early, [&] {
      return "homing was aborted " + duration_text(since) +
             " after its start, before the drive had sent a statusword: bits 10 and 12 were still "
             "those of the previous homing";
    });
  }
  const bool is_pulse = since < kPulse;
  context.report(is_pulse ? Rule::homing_pulsed : Rule::homing_given_up, [&] {
    return "homing was aborted " + duration_text(since) +
           " after its start while bits 10, 12 and 13 were 0";
  });
}

/// A controlword with bit 4 still set, after a homing that has ended.
void ModeRules::stay_in_homing(const Write& write, const Context& context) {
  const AxisTrack& track = context.track;
  const bool is_meant = write.channel == Channel::sdo || write.channel == Channel::request;
  const bool is_same = write.value == track.controlword;
  // With bit 12 alone, the origin is found but the axis is still moving.
  const bool has_ended = track.shows(Statusword::kHomingAttained | Statusword::kTargetReached) ||
                         track.shows(Statusword::kHomingError);
  if (!is_meant || !is_same || !track.is_enabled() || !track.is_in(OperatingMode::homing) ||
      !has_ended || is_start_kept_reported_) {
    return;
  }
  is_start_kept_reported_ = true;
  context.report(Rule::homing_start_kept, [&] {
    return "6040h = " + hex_text(track.controlword) +
           " was written again after a homing that had ended: bit 4 has no edge";
  });
}

void ModeRules::take_target(const Write& write, const Context& context) {
  const AxisTrack& track = context.track;
  const auto row = std::ranges::find(kTargets, write.object, &TargetRow::object);
  if (row == kTargets.end()) return;
  const auto mode = track.mode_in_force();
  const bool has_own_target =
      mode && *mode > 0 &&
      *mode <= static_cast<std::int8_t>(OperatingMode::cyclic_synchronous_torque) &&
      *mode != static_cast<std::int8_t>(OperatingMode::homing);
  if (!track.is_enabled() || !has_own_target) return;
  if (is_of_mode(*row, *mode)) {
    foreign_writes_ = 0;
    return;
  }
  if (track.mode_wanted && is_of_mode(*row, *track.mode_wanted)) return;  // until 6061h follows
  if (foreign_ == write.object && foreign_value_ == write.value) return;
  foreign_writes_ = foreign_ == write.object ? foreign_writes_ + 1 : 1;
  foreign_ = write.object;
  foreign_value_ = write.value;
  if (foreign_writes_ < kForeignWrites) return;
  foreign_writes_ = 0;
  context.report(Rule::mode_foreign_target, [&] {
    return object_name(write.object) + " changed " + std::to_string(kForeignWrites) + " times in " +
           mode_text(*mode) + ", which ignores it";
  });
}

void ModeRules::take(const Shown& shown, const Context& context) {
  const AxisTrack& track = context.track;
  if (!shown.has(ShownMember::kStatusword)) return;
  if (!track.is_enabled() || !track.is_in(OperatingMode::homing)) {
    homing_start_.reset();
    is_start_kept_reported_ = false;
    return;
  }
  if (homing_start_ && context.now() > *homing_start_) is_homing_shown_ = true;
  if (homing_start_ && is_homing_shown_ && (track.statusword & kHomingEnded) != 0) {
    homing_start_.reset();
  }
  // Bit 4 was set before mode 6 was in force, so nothing starts.
  const Time since = std::max(track.mode_since, track.state_since);
  const bool is_idle = (track.statusword & (kHomingEnded | Statusword::kTargetReached)) ==
                       Statusword::kTargetReached;
  if (is_start_kept_reported_ || !is_idle || !track.mode_shown ||
      !track.commands(Controlword::kStartHoming) || homing_start_ ||
      track.controlword_time < since || context.now() - track.controlword_time < kNeverStarted) {
    return;
  }
  is_start_kept_reported_ = true;
  context.report(Rule::homing_start_kept, [] {
    return std::string("bit 4 was up before mode 6 was in force, so homing has not started");
  });
}

}  // namespace vdrive::judge
