// SPDX-License-Identifier: Apache-2.0
#include "execution/motion_end.hpp"

#include <string>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

/// Suspends an interrupt, which would also end calls that only read an axis.
class SuspendedInterrupt {
 public:
  explicit SuspendedInterrupt(client::Session& session)
      : session_(session), was_interrupted_(session.is_interrupted()) {
    if (was_interrupted_) session_.end_interrupt();
  }

  ~SuspendedInterrupt() {
    if (was_interrupted_) session_.interrupt();
  }

  SuspendedInterrupt(const SuspendedInterrupt&) = delete;
  SuspendedInterrupt& operator=(const SuspendedInterrupt&) = delete;

 private:
  client::Session& session_;
  const bool was_interrupted_;
};

bool has_motion(const client::AxisSnapshot& axis) {
  return axis.status.velocity_demand_value != 0 || axis.has_torque();
}

/// Checks control, because the command may have ended before it had control, and the axis of
/// another session must not be halted.
/// @param may_begin the motion may have been commanded without being visible yet
bool is_driven_here(const client::Session& session, const client::Axis& axis, bool may_begin) {
  const auto shown = axis.status();
  return shown && shown->owner_session == session.id() &&
         shown->state() == PowerState::operation_enabled && (may_begin || has_motion(*shown));
}

/// @return such as "axis 1.1 is halted", or why it is not.
std::string end_text(const Outcome& halted, const client::Axis& axis,
                     const CommandContext& context) {
  return halted ? "axis " + context.axes.label_of(axis.id()) + " is halted" : halted.message();
}

/// @return whether no later command of the session could stop the axis.
bool ends_session(const Outcome& outcome, const CommandContext& context) {
  const bool is_failure =
      outcome.kind() == OutcomeKind::timed_out || outcome.kind() == OutcomeKind::failed;
  return is_failure && !context.outlives_failures;
}

}  // namespace

void halt_after_interrupt(client::Axis& axis, const CommandContext& context) {
  const Outcome halted = axis.halt();
  context.output.terminal.print_error("vdrive: interrupted; " + end_text(halted, axis, context));
}

Outcome end_endless_motion(client::Axis& axis, Outcome outcome, CommandContext& context) {
  const bool is_interrupted = context.session.is_interrupted();
  if (outcome || (!is_interrupted && !ends_session(outcome, context))) return outcome;
  context.progress.end();
  const SuspendedInterrupt aside(context.session);
  const bool may_begin = is_interrupted || outcome.kind() == OutcomeKind::timed_out;
  const bool is_driven = is_driven_here(context.session, axis, may_begin);
  if (is_interrupted && is_driven) {
    halt_after_interrupt(axis, context);
  } else if (is_interrupted) {
    context.output.terminal.print_error("vdrive: " + outcome.message());
  } else if (is_driven) {
    const Outcome halted = axis.halt();
    return outcome.with_message(
        outcome.message() + "; " + end_text(halted, axis, context) +
        (halted ? ", because nothing would stop it after the session" : ""));
  }
  return outcome;
}

}  // namespace vdrive::tool
