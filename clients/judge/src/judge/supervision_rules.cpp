// SPDX-License-Identifier: Apache-2.0
#include "judge/supervision_rules.hpp"

#include "judge/words.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cstdlib>
#include <string>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;

constexpr Time kFaultReaction = 200ms;  ///< for messages sent before the master saw the fault
constexpr Time kFallReaction = 500ms;
constexpr std::uint32_t kBlindCommands = 3;
constexpr Time kLimitReaction = 200ms;
constexpr std::uint32_t kOutwards = 10;
constexpr Time kStoreDistance = 60s;

bool is_target(ObjectAddress object) {
  return object == objects::kTarget || object == objects::kTargetVelocity ||
         object == objects::kTargetTorque || object == objects::kInterpolationRecord;
}

/// @return whether a target causes no motion, such as a 607Ah that tracks 6064h so that the axis
///         does not jump when it is powered.
bool rests(const Write& write, const AxisTrack& track) {
  if (write.object == objects::kTargetVelocity || write.object == objects::kTargetTorque) {
    return write.value == 0;
  }
  return track.is_near(static_cast<std::int32_t>(write.value));
}

}  // namespace

void SupervisionRules::forget() {
  *this = {};
}

void SupervisionRules::take(const Write& write, const Context& context) {
  if (!is_taken(write)) return;
  const AxisTrack& track = context.track;
  if (write.object == objects::kStore) {
    if (stored_ && context.now() - *stored_ < kStoreDistance) {
      context.report(Rule::supervision_store_often, [&] {
        return "1010h:1 was written again after " + duration_text(context.now() - *stored_);
      });
    }
    stored_ = context.now();
    return;
  }
  if (write.object == objects::kControlword) {
    const auto word = static_cast<std::uint16_t>(write.value);
    const bool rises =
        (word & Controlword::kNewSetPoint) != 0 && !track.commands(Controlword::kNewSetPoint);
    if (rises && track.has_controlword) take_motion(context);
    return;
  }
  if (!is_target(write.object)) return;
  const bool is_new = write.object == objects::kTarget
                          ? track.target != write.value
                          : track.values.find(write.object) != write.value;
  if (!is_new) return;
  if (!rests(write, track)) take_motion(context);
  if (write.object == objects::kTarget) {
    take_streamed(static_cast<std::int32_t>(write.value), context);
  }
}

/// A set-point that the drive cannot follow because it has no power.
void SupervisionRules::take_motion(const Context& context) {
  const AxisTrack& track = context.track;
  if (!track.has_status) return;
  if (is_fault(track.state)) {
    const Time since = context.now() - track.state_since;
    if (since < kFaultReaction || ++blind_ < kBlindCommands) return;
    context.report(Rule::supervision_goes_on_after_fault, [&] {
      return "set-points continue " + duration_text(since) + " after 6041h became " +
             std::string(to_string(track.state));
    });
  } else if (fell_) {
    const Time since = context.now() - *fell_;
    if (since < kFallReaction || ++blind_ < kBlindCommands) return;
    context.report(Rule::supervision_fall_unnoticed, [&] {
      return "set-points continue " + duration_text(since) + " after the drive changed to " +
             std::string(to_string(track.state)) + " without a fault and without a command";
    });
  }
}

void SupervisionRules::take_streamed(std::int64_t target, const Context& context) {
  const AxisTrack& track = context.track;
  const auto before = last_target_;
  last_target_ = target;
  if (!limited_ || !before || !track.position || !track.is_enabled()) return;
  const std::int64_t actual = *track.position;
  const bool is_further = std::abs(target - actual) > std::abs(*before - actual) &&
                          (target > actual) == (*before > actual);
  outwards_ = is_further ? outwards_ + 1 : 0;
  if (outwards_ < kOutwards || context.now() - *limited_ < kLimitReaction) return;
  outwards_ = 0;
  context.report(Rule::supervision_into_limit, [&] {
    return "607Ah = " + std::to_string(target) + " is the " + std::to_string(kOutwards) +
           "th target in a row that leads further from 6064h = " + std::to_string(actual) + ", " +
           duration_text(context.now() - *limited_) + " after bit 11 rose";
  });
}

void SupervisionRules::take(const Shown& shown, const Context& context) {
  if (!shown.has(ShownMember::kStatusword)) return;
  const AxisTrack& track = context.track;
  if (!track.shows(Statusword::kInternalLimitActive) || !track.is_enabled()) {
    limited_.reset();
    outwards_ = 0;
  } else if (!limited_) {
    limited_ = context.now();
  }
  if (track.state == track.state_before) return;
  blind_ = 0;
  const bool is_down = track.state == PowerState::switched_on ||
                       track.state == PowerState::ready_to_switch_on ||
                       track.state == PowerState::switch_on_disabled;
  const bool was_commanded = track.command != PowerCommand::enable_operation;
  if (track.state_before == PowerState::operation_enabled && is_down && !was_commanded) {
    fell_ = context.now();
  } else if (!is_down) {
    fell_.reset();
  }
}

void SupervisionRules::take(const KeepAlive& sign, const Context& context) {
  constexpr int kShareOfLimit = 5;  // reported beyond four fifths of the limit
  if (last_sign_) {
    const Time silence = context.now() - *last_sign_;
    if (silence > sign.limit / kShareOfLimit * (kShareOfLimit - 1) && silence > longest_silence_) {
      longest_silence_ = silence;
      context.report(Rule::supervision_keep_alive, [&] {
        return "the master was silent for " + duration_text(silence) +
               "; the limit of the drive is " + duration_text(sign.limit);
      });
    }
  }
  last_sign_ = context.now();
}

void SupervisionRules::take(const Network& network, const Context& context) {
  if (!network.is_command || network.state == NodeState::operational) return;
  if (context.track.is_enabled()) {
    context.report(Rule::supervision_left_enabled, [] {
      return std::string("the NMT master stopped or reset the node in Operation enabled");
    });
  }
}

void SupervisionRules::end(const Context& context) {
  if (!context.track.is_enabled() && context.track.state != PowerState::quick_stop_active) return;
  if (!context.track.has_status) return;
  context.report(Rule::supervision_left_enabled, [&] {
    return "the run ended in " + std::string(to_string(context.track.state));
  });
}

}  // namespace vdrive::judge
