// SPDX-License-Identifier: Apache-2.0
#include "judge/handshake_rules.hpp"

#include "judge/words.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <string>
#include <utility>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;

constexpr Time kAcknowledgeTime = 100ms;  ///< a drive that takes a set-point acknowledges it sooner
constexpr Time kNeverAcknowledged = 1s;
constexpr Time kLoopOfADrive = 1ms;      ///< the shortest in any manual
constexpr Time kStreamDistance = 100ms;  ///< longest interval between the targets of a stream
constexpr std::uint32_t kStreamTargets = 20;
constexpr std::uint32_t kKeptRelative = 2;

bool is_up(std::uint16_t word, std::uint16_t bit) {
  return (word & bit) != 0;
}

}  // namespace

void HandshakeRules::forget() {
  *this = {};
}

void HandshakeRules::take(const Write& write, const Context& context) {
  if (write.fate == Fate::refused || write.fate == Fate::late) return;
  if (write.object == objects::kControlword) {
    take_word(write, static_cast<std::uint16_t>(write.value), context);
  } else if (write.object == objects::kTarget) {
    take_target(write, context);
  }
}

void HandshakeRules::take_word(const Write& write, std::uint16_t word, const Context& context) {
  const std::uint16_t before = context.track.controlword;
  watch_pulse(word, context);
  const bool is_set = is_up(word, Controlword::kNewSetPoint);
  const bool was_set = is_up(before, Controlword::kNewSetPoint);
  if (is_set && was_set) return stay(write, context);
  if (was_set) return fall(word, context);
  if (!is_set || !context.track.has_controlword) return;
  if (write.fate == Fate::ignored) {
    context.report(Rule::handshake_not_taken, [&] {
      return "the drive ignored the edge of bit 4 in " + state_and_mode_text(context.track);
    });
  }
  rise(word, context);
}

/// A bit that acts by its edge must stay set until the drive has seen it.
void HandshakeRules::watch_pulse(std::uint16_t word, const Context& context) {
  const AxisTrack& track = context.track;
  const auto rises = [&](std::uint16_t bit) {
    return !is_up(track.controlword, bit) && is_up(word, bit);
  };
  if (pulse_ && is_up(track.controlword, pulse_->bit) && !is_up(word, pulse_->bit)) {
    end_pulse(context);
  }
  // The length of a pulse matters only if the drive would act on its edge.
  const bool starts = track.is_enabled() && (track.is_in(OperatingMode::profile_position) ||
                                             track.is_in(OperatingMode::homing));
  if (rises(Controlword::kNewSetPoint) && track.has_controlword && starts) {
    pulse_ = Pulse{.bit = Controlword::kNewSetPoint, .time = context.now()};
  } else if (rises(Controlword::kFaultReset) && track.has_status &&
             track.state == PowerState::fault) {
    pulse_ = Pulse{.bit = Controlword::kFaultReset, .time = context.now()};
  }
}

void HandshakeRules::end_pulse(const Context& context) {
  const Pulse pulse = *std::exchange(pulse_, std::nullopt);
  const Time length = context.now() - pulse.time;
  if (context.track.status_time > pulse.time || length >= kLoopOfADrive) return;
  context.report(Rule::handshake_short_pulse, [&] {
    return "bit " + std::string(pulse.bit == Controlword::kFaultReset ? "7" : "4") +
           " was set for only " + duration_text(length);
  });
}

void HandshakeRules::rise(std::uint16_t word, const Context& context) {
  const AxisTrack& track = context.track;
  if (!track.has_status || !track.is_in(OperatingMode::profile_position)) return;
  if (!track.is_enabled()) {
    const bool is_power_on =
        decode_command(word, track.controlword) == PowerCommand::enable_operation;
    if (is_power_on && !is_fault(track.state)) {
      context.report(Rule::handshake_not_enabled, [&] {
        return "bit 4 rose while 6041h showed " + std::string(to_string(track.state));
      });
    }
    return;
  }
  // Some drives show bit 12 from enabling until the first set-point.
  const bool is_of_this_mode = track.is_status_pushed || track.status_time >= track.mode_since;
  if (track.shows(Statusword::kSetPointAcknowledge) && has_taken_ && is_of_this_mode) {
    context.report(Rule::handshake_before_acknowledge_fell, [&] {
      return "bit 4 rose while 6041h was " + hex_text(track.statusword) +
             ": bit 12 is still 1, so the drive cannot see a new set-point";
    });
  } else {
    ++stream_edges_;
  }
  has_taken_ = true;
  edge_ = Edge{.time = context.now(), .had_target = has_target_};
  has_target_ = false;
  targets_without_edge_ = 0;
  if (!is_up(word, Controlword::kRelative)) {
    had_absolute_ = true;
    relative_kept_ = 0;
  } else if (is_relative_left_ && had_absolute_) {
    if (++relative_kept_ >= kKeptRelative) {
      context.report(Rule::handshake_relative_stays, [&] {
        return "bit 6 has stayed set since an earlier set-point, also in controlwords with bit 4 = "
               "0";
      });
    }
  }
}

void HandshakeRules::fall(std::uint16_t word, const Context& context) {
  is_relative_left_ = is_up(word, Controlword::kRelative);
  targets_without_edge_ = 0;
  if (!edge_) return;
  const AxisTrack& track = context.track;
  const bool is_known = track.is_status_pushed || track.status_time > edge_->time;
  const Time waited = context.now() - edge_->time;
  if (!edge_->is_acknowledged && !edge_->is_reported && is_known && track.is_enabled() &&
      waited >= kAcknowledgeTime) {
    context.report(Rule::handshake_not_taken, [&] {
      return "bit 4 fell after " + duration_text(waited) + ", and bit 12 had not risen";
    });
  }
  edge_.reset();
}

/// A controlword with bit 4 still set.
void HandshakeRules::stay(const Write& write, const Context& context) {
  if (targets_without_edge_ == 0 || !edge_ || !edge_->is_acknowledged) return;
  // In other modes bit 4 is a level or unused.
  if (!context.track.is_in(OperatingMode::profile_position)) return;
  // A PDO repeats its controlword each cycle, also while the master prepares its next target.
  const bool is_meant = write.channel != Channel::pdo;
  if (!is_meant && context.now() - first_without_edge_ < kAcknowledgeTime) return;
  targets_without_edge_ = 0;
  context.report(Rule::handshake_no_edge, [&] {
    return "607Ah is " + std::to_string(context.track.target.value_or(0)) +
           ", and 6040h = " + hex_text(static_cast<std::uint16_t>(write.value)) +
           " has bit 4 set, like the previous controlword";
  });
}

void HandshakeRules::take_target(const Write& write, const Context& context) {
  const AxisTrack& track = context.track;
  const bool is_new = track.target != static_cast<std::int32_t>(write.value);
  const bool had_target = has_target_;
  has_target_ = true;
  if (!track.is_enabled() || !track.is_in(OperatingMode::profile_position)) return;
  if (!is_new) return;
  note_stream(context);
  if (!edge_) return;
  const bool is_late =
      !edge_->is_acknowledged || (!edge_->had_target && saw_disabled_ && !had_target);
  if (is_late) {
    if (edge_->is_reported) return;
    edge_->is_reported = true;
    context.report(Rule::handshake_target_after_edge, [&] {
      return "607Ah = " + std::to_string(write.value) + " came " +
             duration_text(context.now() - edge_->time) + " after bit 4 had risen";
    });
    return;
  }
  if (++targets_without_edge_ == 1) {
    first_without_edge_ = context.now();
  } else {
    context.report(Rule::handshake_no_edge, [&] {
      return "607Ah = " + std::to_string(*track.target) +
             " had no edge, and 607Ah = " + std::to_string(write.value) +
             " replaces it while bit 4 stays up";
    });
  }
}

void HandshakeRules::note_stream(const Context& context) {
  if (context.now() - last_target_ > kStreamDistance) {
    stream_targets_ = 0;
    stream_edges_ = 0;
  }
  last_target_ = context.now();
  ++stream_targets_;
  // Without any edge the targets are not set-points: 607Ah may be tracking 6064h.
  if (stream_targets_ < kStreamTargets || stream_edges_ == 0 ||
      stream_edges_ + 1 >= stream_targets_) {
    return;
  }
  context.report(Rule::handshake_stream, [&] {
    return std::to_string(stream_edges_) + " of " + std::to_string(stream_targets_) +
           " targets in a row had an edge that the drive could see; the others are lost";
  });
}

void HandshakeRules::take(const Shown& shown, const Context& context) {
  if (!shown.has(ShownMember::kStatusword)) return;
  const AxisTrack& track = context.track;
  if (!track.is_enabled()) {
    saw_disabled_ = true;
    has_taken_ = false;
    edge_.reset();
    return;
  }
  if (!edge_) return;
  if (track.shows(Statusword::kSetPointAcknowledge)) edge_->is_acknowledged = true;
  if (edge_->is_acknowledged || edge_->is_reported ||
      !track.is_in(OperatingMode::profile_position)) {
    return;
  }
  const Time waited = context.now() - edge_->time;
  if (waited < kNeverAcknowledged) return;
  edge_->is_reported = true;
  context.report(Rule::handshake_not_taken, [&] {
    return "bit 12 did not rise within " + duration_text(waited) + " of the edge of bit 4";
  });
}

}  // namespace vdrive::judge
