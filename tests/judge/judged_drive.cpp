// SPDX-License-Identifier: Apache-2.0
#include "judge/judged_drive.hpp"

#include "judge/axis_track.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <algorithm>
#include <stdexcept>

namespace vdrive::judge {
namespace {

constexpr std::chrono::microseconds kPeriod{1000};

}  // namespace

JudgedDrive::JudgedDrive(const TestSource& source, const AxisConfiguration& configuration,
                         std::uint32_t number)
    : own_(std::in_place, source.facts),
      judge_(&*own_),
      source_(source),
      axis_(configuration, kPeriod),
      number_(number) {
  show();
}

JudgedDrive::JudgedDrive(Judge& judge, const TestSource& source,
                         const AxisConfiguration& configuration, std::uint32_t number)
    : judge_(&judge), source_(source), axis_(configuration, kPeriod), number_(number) {
  show();
}

void JudgedDrive::take(const decltype(Record::what)& what) {
  judge_->take({.time = tick_ * Time(kPeriod), .tick = tick_, .axis = number_, .what = what});
}

Fate JudgedDrive::write(ObjectAddress object, std::int64_t value, Channel channel,
                        std::uint64_t writer) {
  const AbortCode code = axis_.write(object, value);
  const Fate fate = code == AbortCode::none ? Fate::accepted : Fate::refused;
  take(Write{.object = object,
             .value = value,
             .channel = channel,
             .fate = fate,
             .code = wire_code(code),
             .writer = writer});
  return fate;
}

void JudgedDrive::word(std::uint16_t word, Channel channel, std::uint64_t writer) {
  write(objects::kControlword, word, channel, writer);
}

void JudgedDrive::target(std::int32_t target, Channel channel) {
  write(objects::kTarget, target, channel);
}

void JudgedDrive::mode(std::int8_t mode) {
  write(objects::kMode, mode);
}

void JudgedDrive::read(ObjectAddress object) {
  const ReadResult result = axis_.read(object);
  take(Reading{.object = object, .value = result.value, .code = wire_code(result.code)});
  if (object == objects::kModeShown) {
    take(Shown{.members = ShownMember::kMode,
               .mode = static_cast<std::int8_t>(result.value),
               .is_asked_for = true});
  }
}

void JudgedDrive::disturb(ObjectAddress object, std::int64_t value) {
  if (axis_.write(object, value) != AbortCode::none) throw std::logic_error("no such input");
}

void JudgedDrive::show() {
  shown_ = axis_.status();
  if (pretended_) {
    shown_.ds402_statusword = static_cast<std::uint16_t>(
        (shown_.ds402_statusword & ~Statusword::kState) | statusword_of(*pretended_));
  }
  const AxisStatus& status = shown_;
  Shown shown{.members = ShownMember::kStatusword | ShownMember::kPosition | ShownMember::kDemand |
                         ShownMember::kFollowingError | ShownMember::kTorque,
              .statusword = statusword(),
              .error_code = status.error_code,
              .torque = status.torque_actual_value,
              .position = status.load_position_actual_value,
              .demand = status.position_demand_value,
              .following_error = status.load_position_error_value,
              .mode = status.op_mode_actual};
  if (source_.shows_mode) shown.members |= ShownMember::kMode;
  if (source_.shows_error_code) shown.members |= ShownMember::kErrorCode;
  take(shown);
}

void JudgedDrive::step(std::uint64_t ticks) {
  for (std::uint64_t i = 0; i < ticks; ++i) {
    axis_.step();
    ++tick_;
    if (tick_ % source_.ticks_a_status == 0) show();
  }
}

bool JudgedDrive::step_until(const std::function<bool()>& done, std::uint64_t deadline) {
  for (std::uint64_t i = 0; i < deadline; ++i) {
    step(source_.ticks_a_status - tick_ % source_.ticks_a_status);
    if (done()) return true;
  }
  return false;
}

bool JudgedDrive::step_until_state(PowerState state) {
  return step_until([this, state] {
    return decode_power_state(statusword()) == state;
  });
}

bool JudgedDrive::step_until_bits(std::uint16_t mask, std::uint16_t value, std::uint64_t deadline) {
  return step_until(
      [this, mask, value] {
        return (statusword() & mask) == value;
      },
      deadline);
}

void JudgedDrive::enable(std::int8_t wanted) {
  if (shown_.op_mode_actual != wanted) {
    mode(wanted);
    step_until([this, wanted] {
      return shown_.op_mode_actual == wanted;
    });
  }
  word(controlwords::kShutdown);
  step_until_state(PowerState::ready_to_switch_on);
  word(controlwords::kSwitchOn);
  step_until_state(PowerState::switched_on);
  word(controlwords::kEnableOperation);
  if (!step_until_state(PowerState::operation_enabled)) throw std::logic_error("not enabled");
}

void JudgedDrive::disable() {
  word(controlwords::kShutdown);
  step_until_state(PowerState::ready_to_switch_on);
}

void JudgedDrive::set_point(std::int32_t to, std::uint16_t bits) {
  target(to);
  word(static_cast<std::uint16_t>(controlwords::kEnableOperation | Controlword::kNewSetPoint |
                                  bits));
  step_until_bits(Statusword::kSetPointAcknowledge, Statusword::kSetPointAcknowledge);
  word(controlwords::kEnableOperation);
  step_until_bits(Statusword::kSetPointAcknowledge, 0);
}

bool JudgedDrive::move(std::int32_t to, std::uint16_t bits) {
  set_point(to, bits);
  return step_until_bits(Statusword::kTargetReached, Statusword::kTargetReached);
}

std::vector<std::string> JudgedDrive::findings(bool is_over) {
  return broken_rules(end(is_over));
}

std::vector<std::string> broken_rules(const Verdict& verdict) {
  std::vector<Rule> broken;
  for (const Finding& finding : verdict.findings) broken.push_back(finding.rule);
  std::ranges::sort(broken);
  broken.erase(std::unique(broken.begin(), broken.end()), broken.end());
  std::vector<std::string> names;
  for (const Rule rule : broken) names.emplace_back(row_of(rule).name);
  return names;
}

}  // namespace vdrive::judge
