// SPDX-License-Identifier: Apache-2.0
#include "calls/axes_command.hpp"

#include "base/ask.hpp"
#include "calls/arrival.hpp"
#include "calls/slow_drive.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/standing_targets.hpp"
#include "vdrive/client/command_words.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

constexpr std::string_view kResetFirst = "a fault reset first";
constexpr std::string_view kQuickStopEnd = "the quick stop to end";

bool in_every_state(PowerState /*state*/) {
  return true;
}

bool in_no_state(PowerState /*state*/) {
  return false;
}

bool without_fault(PowerState state) {
  return !is_fault(state);
}

bool in_operation(PowerState state) {
  return state == PowerState::operation_enabled;
}

}  // namespace

struct AxesCommand::Row {
  /// How many axes of a group must be able to take the command; the others are left out.
  enum class Takers : std::uint8_t { all, one, any };

  EachCommand command;
  std::string_view name{};        ///< in a refusal
  std::string_view needs{};       ///< required state or action before it
  bool (*can_take)(PowerState);   ///< otherwise it is refused
  bool (*is_at_end)(PowerState);  ///< nothing remains to be done
  Takers takers = Takers::all;
  bool is_stop = false;  ///< also acts on axes of other sessions
  Timing timing = Timing::at_once;
  void (AxesCommand::*await_before)() = nullptr;
  std::string_view awaited;
  PowerState end_state = PowerState::operation_enabled;  ///< for await_end_state()
  /// true: afterwards the axis must be in Operation enabled; false: only without a fault.
  bool stays_enabled = false;
  bool ends_faults = false;      ///< afterwards no axis of the group has a fault
  void (AxesCommand::*reach)();  ///< waits until it is done
};

constinit const std::array<AxesCommand::Row, 7> AxesCommand::kRows{
    Row{.command = EachCommand::enable,
        .name = "enabling",
        .needs = kResetFirst,
        .can_take = without_fault,
        .is_at_end = in_operation,
        .await_before = &AxesCommand::await_quick_stops,
        .awaited = "Operation enabled",
        .stays_enabled = true,
        .reach = &AxesCommand::await_operation},
    Row{.command = EachCommand::disable,
        .name = "disabling",
        .needs = kResetFirst,
        .can_take = without_fault,
        .is_at_end = in_no_state,
        .takers = Row::Takers::any,
        .await_before = &AxesCommand::await_quick_stops,
        .awaited = "Ready to switch on",
        .end_state = PowerState::ready_to_switch_on,
        .reach = &AxesCommand::await_end_state},
    Row{.command = EachCommand::halt,
        .name = "a halt",
        .needs = "Operation enabled",
        .can_take = in_operation,
        .is_at_end = in_no_state,
        .takers = Row::Takers::one,
        .is_stop = true,
        .timing = Timing::common_tick,
        .awaited = "standstill, bit 10",
        .stays_enabled = true,
        .reach = &AxesCommand::await_standstill},
    Row{.command = EachCommand::resume,
        .name = "resuming",
        .needs = "Operation enabled",
        .can_take = in_operation,
        .is_at_end = in_no_state,
        .timing = Timing::common_tick,
        .awaited = kTargetReached,
        .stays_enabled = true,
        .reach = &AxesCommand::await_targets},
    Row{.command = EachCommand::quick_stop,
        .name = "a quick stop",
        .needs = kResetFirst,
        .can_take = without_fault,
        .is_at_end = in_no_state,
        .takers = Row::Takers::any,
        .is_stop = true,
        .awaited = kQuickStopEnd,
        .reach = &AxesCommand::await_end_of_stop},
    Row{.command = EachCommand::reset_fault,
        .can_take = in_every_state,
        .is_at_end = without_fault,
        .await_before = &AxesCommand::await_end_of_reaction,
        .awaited = "the end of the fault",
        .ends_faults = true,
        .reach = &AxesCommand::await_reset},
    Row{.command = EachCommand::power_cycle,
        .can_take = in_every_state,
        .is_at_end = in_no_state,
        .awaited = "Switch on disabled",
        .end_state = PowerState::switch_on_disabled,
        .ends_faults = true,
        .reach = &AxesCommand::await_end_state},
};

const AxesCommand::Row& AxesCommand::row_of(EachCommand command) {
  const auto* const row = std::ranges::find(kRows, command, &Row::command);
  ensure(row != kRows.end(), "every command has a row");
  return *row;
}

AxesCommand::AxesCommand(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
                         EachCommand command, const CallOptions& options,
                         ObservedAxes::Progress progress)
    : core_(core),
      call_(std::move(core), std::move(layout), caller, std::move(progress)),
      row_(row_of(command)),
      options_(options),
      outcomes_(call_.axes().layout().axes.size()),
      is_pending_(outcomes_.size(), true),
      is_held_(outcomes_.size(), false),
      at_end_(outcomes_.size()) {
  if (row_.is_stop) stop_.emplace(core_->wakeup);
}

void AxesCommand::open() {
  if (Outcome opened = call_.open(); !opened) end_all(opened);
}

void AxesCommand::begin() {
  if (!has_pending()) return;
  if (Outcome begun = begin_call(); !begun) return end_all(begun);
  judge();
}

bool AxesCommand::await_before() {
  const bool is_at_once = row_.command == EachCommand::enable && options_.until == Until::in_force;
  if (!has_pending() || is_at_once || row_.await_before == nullptr) return false;
  const std::uint64_t begin = call_.tick();
  (this->*row_.await_before)();
  if (!has_pending() || call_.tick() == begin) return call_.tick() != begin;
  // The axes may have changed during the wait; in a group, even an axis that needed nothing before
  // may need the command now.
  if (is_group()) is_pending_.assign(is_pending_.size(), true);
  if (is_group() || row_.command == EachCommand::reset_fault) judge();
  return true;
}

void AxesCommand::refresh() {
  if (!has_pending()) return;
  if (Outcome seen = call_.axes().refresh(); !seen) return end_all(seen);
  judge();
}

void AxesCommand::send() {
  if (has_pending() && sends_before_answers()) call_.begin_to_put_in_force(rounds());
}

void AxesCommand::await_in_force(std::set<std::uint32_t>& stepped) {
  if (!has_pending()) return;
  Outcome done;
  if (sends_before_answers()) {
    const std::uint32_t bench = call_.axes().layout().axes.front().bench;
    done = call_.await_in_force(stepped.contains(bench));
    if (done) stepped.insert(bench);
  } else {
    done = row_.command == EachCommand::power_cycle ? power_cycle() : put_in_force();
  }
  if (!done) return end_all(done);
  judge_in_force();
}

void AxesCommand::close_unless_pending() {
  if (!has_pending()) call_.axes().close();
}

void AxesCommand::finish() {
  if (!has_pending() || options_.until == Until::in_force) return;
  (this->*row_.reach)();
  conclude();
}

void AxesCommand::carry_out() {
  await_before();
  send();
  std::set<std::uint32_t> stepped;
  await_in_force(stepped);
  finish();
}

// ---- outcomes --------------------------------------------------------------------------------

void AxesCommand::end(std::size_t place, Outcome outcome) {
  if (!is_pending_[place]) return;
  if (is_group() && !outcome) return end_all(outcome);
  outcomes_[place] = std::move(outcome);
  is_pending_[place] = false;
}

void AxesCommand::end_all(const Outcome& outcome) {
  for (const std::size_t place : pending_places()) {
    outcomes_[place] = outcome;
    is_pending_[place] = false;
  }
}

std::vector<std::size_t> AxesCommand::pending_places() const {
  std::vector<std::size_t> places;
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (is_pending_[place]) places.push_back(place);
  }
  return places;
}

bool AxesCommand::has_pending() const {
  return std::ranges::find(is_pending_, true) != is_pending_.end();
}

Outcome AxesCommand::outcome() const {
  const auto failed = std::ranges::find_if_not(outcomes_, [](const Outcome& outcome) {
    return static_cast<bool>(outcome);
  });
  return failed == outcomes_.end() ? Outcome() : *failed;
}

/// Stops a group if an axis is not in Operation enabled although the command should leave it there.
void AxesCommand::conclude_group() {
  if (row_.stays_enabled && !is_left_out_ && has_pending()) {
    end_all(call_.check(row_.awaited, from_));
  }
  if (row_.ends_faults) end_if_faulty();
}

/// Sets a failure for each axis that did not reach the awaited state.
void AxesCommand::conclude() {
  if (is_group()) return conclude_group();
  std::optional<Outcome> service;  // asked once
  for (const std::size_t place : pending_places()) {
    const AxisSnapshot& axis = at_end_[place];
    if (row_.stays_enabled ? is_enabled(axis) : has_no_fault(axis)) continue;
    Outcome failed = failed_instead_of(row_.awaited, axis);
    if (!service && has_no_fault(axis)) service = call_.check_service(axis);
    const bool has_ended = service && !*service;
    end(place,
        has_ended ? service->with_message(service->message() + "; " + failed.message()) : failed);
  }
}

/// Sets a failure for a group if an axis has a fault, whether or not the command was for that axis.
void AxesCommand::end_if_faulty() {
  if (call_.tick() < from_ || !outcome()) return;
  const auto faulty = std::ranges::find_if_not(call_.snapshots(), has_no_fault);
  if (faulty == call_.snapshots().end()) return;
  outcomes_.front() = still_faulty(*faulty);
}

Outcome AxesCommand::still_faulty(const AxisSnapshot& axis) const {
  Outcome failed = failed_instead_of(row_.awaited, axis);
  if (row_.command != EachCommand::reset_fault) return failed;
  return not_in_this_state(failed.message() + ", the cause persists");
}

// ---- start -----------------------------------------------------------------------------------

Outcome AxesCommand::begin_call() {
  if (Outcome begun = call_.begin(options_.timeout); !begun) return begun;
  if (stop_) return begin_stop();
  const bool needs_control = row_.command != EachCommand::power_cycle || is_group();
  return needs_control ? acquire() : Outcome();
}

Outcome AxesCommand::begin_stop() {
  for (const BenchPart& part : call_.axes().parts()) {
    if (!core_->links.may_command()) return not_permitted(part.target);
    if (!is_group() && core_->discovery.is_paused(part.target.key)) {
      return Outcome::failed(paused_text(part.target));
    }
    for (const std::size_t place : part.bench->places) {
      is_held_[place] = call_.has_control_of(part.target, call_.snapshots()[place]);
    }
  }
  return {};
}

/// Acquires all axes together, or one by one if another session owns some of them.
Outcome AxesCommand::acquire() {
  constexpr std::uint32_t kLocalControl = wire_code(AbortCode::refused_local_control);
  Outcome taken = call_.acquire();
  const bool all_or_nothing = is_group() || outcomes_.size() == 1;
  if (taken || taken.code() != kLocalControl || all_or_nothing) return taken;
  const BenchPart& part = call_.axes().parts().front();
  for (std::size_t place = 0; place < outcomes_.size(); ++place) {
    Outcome own = core_->control.acquire(part.target, {&call_.snapshots()[place].id.axis, 1});
    if (!own) end(place, core_->names.with_session_name(part.target, std::move(own)));
  }
  return {};
}

/// @return whether the state of the axes forbids the command.
bool AxesCommand::refuses_any() const {
  if (is_group() && row_.takers == Row::Takers::any) return false;
  const auto refuses = [this](std::size_t place) {
    const PowerState state = call_.snapshots()[place].state();
    return !row_.is_at_end(state) && !row_.can_take(state);
  };
  const auto places = pending_places();
  return is_group() && row_.takers == Row::Takers::one ? std::ranges::all_of(places, refuses)
                                                       : std::ranges::any_of(places, refuses);
}

void AxesCommand::judge() {
  if (refuses_any()) {
    if (Outcome seen = call_.axes().look_again(); !seen) return end_all(seen);
  }
  const bool is_refused = refuses_any();
  for (const std::size_t place : pending_places()) {
    const AxisSnapshot& axis = call_.snapshots()[place];
    if (row_.is_at_end(axis.state())) {
      end(place, {});
    } else if (!row_.can_take(axis.state())) {
      is_left_out_ = true;
      end(place, is_refused ? refused_in_state(axis, row_.name, row_.needs) : Outcome());
    }
  }
}

void AxesCommand::await_end_of_reaction() {
  await_each("the fault reaction to end", call_.tick(), [this](std::size_t place) {
    return call_.snapshots()[place].state() != PowerState::fault_reaction_active;
  });
}

// ---- in force --------------------------------------------------------------------------------

/// A group waits for the answers before it steps a tick, so that a refusal has changed nothing.
bool AxesCommand::sends_before_answers() const {
  return !is_group() && !stop_ && row_.command != EachCommand::power_cycle;
}

bool AxesCommand::stops_if_lost() const {
  return is_group() && row_.command == EachCommand::halt;
}

/// Round n contains word n of each axis.
std::vector<Round> AxesCommand::rounds() const {
  std::vector<Round> rounds;
  for (const std::size_t place : pending_places()) {
    auto words = words_to(row_.command, call_.snapshots()[place].state());
    if (std::ranges::find(streams_, place) != streams_.end()) words = {kReleaseStream};
    rounds.resize(std::max(rounds.size(), words.size()));
    for (std::size_t i = 0; i < words.size(); ++i) {
      msg::AxisCommand command = call_.command_to(place);
      add_word(command, words[i]);
      const bool gives_power = row_.command == EachCommand::enable && words[i] == kEnableOperation;
      if (gives_power && !options_.keep_target) {
        // Otherwise the axis would immediately follow targets left by another program.
        for (const ObjectAddress target : kStandingTargets) add_object(command, target, 0);
      }
      rounds[i].entries.push_back({place, std::move(command)});
    }
  }
  return rounds;
}

Outcome AxesCommand::put_in_force() {
  if (row_.command == EachCommand::halt) {  // needs control; a quick stop does not
    for (BenchPart& part : call_.axes().parts()) {
      if (Outcome taken = acquire_free(part); !taken) return taken;
    }
  }
  const Answers answers = exchange();
  if (!answers.outcome) return answers.outcome;
  from_ = answers.tick;
  if (row_.command == EachCommand::resume) {
    return call_.await_enabled("the release", from_, every_axis);
  }
  Outcome seen = call_.await_tick("the command to take effect", from_);
  return stops_if_lost() ? call_.stop_if_lost(std::move(seen)) : seen;
}

Answers AxesCommand::exchange() {
  const std::vector<Round> all = rounds();
  const Timing timing = is_group() ? row_.timing : Timing::at_once;
  if (stop_) {
    Answers answers = exchange_stop(all.front(), timing);
    if (answers.outcome || timing == Timing::at_once) return answers;
    // A stop in different ticks is better than none.
    return exchange_stop(all.front(), Timing::at_once);
  }
  Answers answers = call_.exchange(all, timing);
  if (!answers.outcome && answers.tick != 0 && row_.command == EachCommand::resume) {
    const Round halt = call_.round_of(kHalt, every_axis);
    (void)call_.exchange({&halt, 1}, Timing::at_once);  // no axis may continue alone
  }
  return answers;
}

Outcome AxesCommand::acquire_free(BenchPart& part) {
  constexpr std::uint32_t kLocalControl = wire_code(AbortCode::refused_local_control);
  std::vector<std::size_t> free;
  std::ranges::copy_if(part.bench->places, std::back_inserter(free), [this](std::size_t place) {
    return call_.snapshots()[place].owner_session == 0;
  });
  if (free.empty()) return {};
  std::vector<std::uint16_t> axes;
  axes.reserve(free.size());
  for (const std::size_t place : free) axes.push_back(call_.snapshots()[place].id.axis);
  Outcome taken = core_->control.acquire(part.target, axes);
  // Another session was faster: the axes that it owns are stopped without control.
  if (taken.code() == kLocalControl) return {};
  if (!taken) return call_.axes().note_lost(part, std::move(taken));
  for (const std::size_t place : free) is_held_[place] = true;
  return {};
}

/// Sends frames to the axes that this session owns, and writes 6040h of the others by requests.
/// @param round the same controlword for all its axes
Answers AxesCommand::exchange_stop(const Round& round, Timing timing) {
  Answers answers;
  if (const std::vector<Round> own = held_of(round); !own.empty()) {
    answers = call_.exchange(own, timing);
  }
  for (BenchPart& part : call_.axes().parts()) {
    if (!part.is_lost()) stop_others(part, round, answers);
  }
  call_.note_in_force(answers.tick);
  return answers;
}

/// @return the part of the round for axes that this session owns, split into rounds that fit in a
///         frame.
std::vector<Round> AxesCommand::held_of(const Round& round) const {
  std::vector<Round> own;
  for (const Round::Entry& entry : round.entries) {
    if (!is_held_[entry.place]) continue;
    if (own.empty() || own.back().entries.size() == msg::MAX_AXES_PER_FRAME) own.emplace_back();
    own.back().entries.push_back(entry);
  }
  return own;
}

void AxesCommand::stop_others(BenchPart& part, const Round& round, Answers& answers) {
  std::vector<std::uint16_t> others;
  for (const Round::Entry& entry : round.entries) {
    const AxisId& id = call_.axes().layout().axes[entry.place];
    if (id.bench == part.bench->number && !is_held_[entry.place]) others.push_back(id.axis);
  }
  if (others.empty()) return;
  const std::uint16_t word = round.entries.front().command.ds402_controlword;
  const auto stopped = core_->control.stop(part.target, others, word);
  if (stopped) {
    answers.tick = std::max(answers.tick, *stopped);
  } else if (answers.outcome) {
    answers.outcome = call_.axes().note_lost(part, stopped.outcome());
  }
}

Outcome AxesCommand::power_cycle() {
  for (const BenchPart& part : call_.axes().parts()) {
    if (Outcome cycled = power_cycle(part); !cycled) return cycled;
  }
  return {};
}

/// Cycles all axes together, or one by one if another session owns some of them.
Outcome AxesCommand::power_cycle(const BenchPart& part) {
  const auto cycle = [&](std::span<const std::size_t> places) {
    std::vector<std::uint16_t> axes;
    for (const std::size_t place : places) axes.push_back(call_.snapshots()[place].id.axis);
    const auto reply = core_->control.exchange(
        part.target, ask::power_cycle(axes),
        "power cycle of " + (axes.size() == 1 ? name_of(part.target, axes.front())
                                              : "axes of " + name_of(part.target)));
    if (!reply) return reply.outcome();
    // The present tick of this call shows the state before the power cycle.
    from_ = std::max({from_, reply->tick, call_.tick() + 1});
    call_.note_in_force(from_);
    return Outcome();
  };
  std::vector<std::size_t> places;
  std::ranges::copy_if(part.bench->places, std::back_inserter(places), [this](std::size_t place) {
    return is_pending_[place];
  });
  if (places.empty()) return {};
  Outcome all = cycle(places);
  const bool all_or_nothing = is_group() || places.size() == 1;
  if (all.kind() != OutcomeKind::refused || all_or_nothing)
    return core_->names.with_session_name(part.target, all);
  for (const std::size_t place : places) {
    const Outcome own = cycle({&place, 1});
    if (!own) end(place, core_->names.with_session_name(part.target, own));
  }
  return {};
}

/// Called in the tick in which the words take effect: nearly every drive has acted by then.
void AxesCommand::judge_in_force() {
  for (const std::size_t place : pending_places()) {
    if (row_.command == EachCommand::reset_fault) {
      judge_reset(place, options_.until == Until::in_force);
    } else if (row_.command == EachCommand::enable && !is_group()) {
      judge_enabling(place);
    }
  }
  if (is_group() && (options_.until == Until::in_force || !has_pending())) conclude();
}

/// In Switched on, the drive is still powering on.
void AxesCommand::judge_enabling(std::size_t place) {
  const AxisSnapshot& axis = call_.snapshots()[place];
  if (is_enabled(axis)) return end(place, {});
  if (options_.until == Until::done) return;
  const bool is_on_its_way = axis.state() == PowerState::switched_on;
  end(place, is_on_its_way ? Outcome() : failed_instead_of(row_.awaited, axis));
}

void AxesCommand::judge_reset(std::size_t place, bool is_over) {
  const AxisSnapshot& axis = call_.snapshots()[place];
  if (has_no_fault(axis)) return end(place, {});
  if (!is_over) return;
  end(place, still_faulty(axis));
}

// ---- finish ----------------------------------------------------------------------------------

/// Waits until `done` has held once for every pending axis, at `from` or later. If the wait fails,
/// the axes for which `done` has not held get their outcomes; in a group, all axes get the same
/// one.
template <typename Done>
void AxesCommand::await_each(std::string_view awaited, std::uint64_t from, const Done& done) {
  std::vector<bool> has_come(is_pending_.size(), false);
  Outcome seen = call_.await(awaited, from, [&](std::size_t place) {
    if (has_come[place] || !is_pending_[place]) return true;
    if (call_.tick() < from || !done(place)) return false;
    has_come[place] = true;
    at_end_[place] = call_.snapshots()[place];
    return true;
  });
  if (!is_group()) return end_late(awaited, seen, has_come);
  if (!seen) end_all(stops_if_lost() ? call_.stop_if_lost(std::move(seen)) : seen);
}

/// Sets the outcome of each axis that has not reached the awaited state.
void AxesCommand::end_late(std::string_view awaited, const Outcome& seen,
                           const std::vector<bool>& has_come) {
  for (const std::size_t place : pending_places()) {
    if (has_come[place]) continue;
    const bool is_late = seen.kind() == OutcomeKind::timed_out && outcomes_.size() > 1;
    end(place, is_late ? timed_out_for(awaited, call_.snapshots()[place]) : seen);
  }
}

void AxesCommand::await_end_state() {
  await_each(row_.awaited, std::max(from_, call_.tick()), [this](std::size_t place) {
    const PowerState present = call_.snapshots()[place].state();
    return present == row_.end_state || is_fault(present);
  });
}

void AxesCommand::await_operation() {
  const auto await_each_answer = [this] {
    const AnswerTime answer_time(call_, kLongestLoop);
    await_each(row_.awaited, call_.tick(), [&](std::size_t place) {
      return has_answered_enabling(call_.snapshots()[place], answer_time);
    });
  };
  await_each_answer();
  const auto walked = enable_step_by_step(call_, pending_places());
  if (!walked) return end_all(walked.outcome());
  if (*walked) await_each_answer();
}

void AxesCommand::await_reset() {
  const AnswerTime answer_time(call_, kLongestReset);
  await_each(row_.awaited, call_.tick(), [&](std::size_t place) {
    return answer_time.has_ended() || has_no_fault(call_.snapshots()[place]);
  });
  std::vector<std::size_t> faulty = pending_places();
  std::erase_if(faulty, [this](std::size_t place) {
    return has_no_fault(call_.snapshots()[place]);
  });
  if (faulty.empty()) return;
  const Outcome held = hold_reset(call_, faulty);
  for (const std::size_t place : faulty) {
    if (held) {
      judge_reset(place, true);
    } else {
      end(place, held);
    }
  }
}

void AxesCommand::await_standstill() {
  await_each(row_.awaited, call_.tick(), [this](std::size_t place) {
    const AxisSnapshot& axis = call_.snapshots()[place];
    return !is_enabled(axis) || stands_still(axis);
  });
}

void AxesCommand::await_end_of_stop() {
  if (const Outcome seen = await_stop_seen(call_); !seen) return end_all(seen);
  await_quick_stops();
}

/// After a resume an axis continues to its target, or is halted again.
void AxesCommand::await_targets() {
  if (is_group()) return end_all(call_.await_enabled(row_.awaited, from_, has_no_way_left));
  std::vector<Outcome> sound(outcomes_.size());
  await_each(kTargetReached, call_.tick(), [&](std::size_t place) {
    sound[place] = call_.check_command(kTargetReached, place);
    return !sound[place] || has_no_way_left(call_.snapshots()[place]);
  });
  const bool is_interrupted = core_->wakeup.is_interrupted();
  for (std::size_t place = 0; place < outcomes_.size(); ++place) {
    const bool goes_on = is_interrupted && outcomes_[place].kind() == OutcomeKind::failed;
    if (goes_on && is_enabled(call_.snapshots()[place])) {
      outcomes_[place] = continues_to_target(call_.snapshots()[place]);
    }
    if (is_pending_[place] && !sound[place]) {
      end(place, call_.explain_lost_power(sound[place], at_end_[place]));
    }
  }
  if (!has_pending()) return;
  const auto words = call_.read(kControlwordObject);
  if (!words) return end_all(words.outcome());
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    const auto word = static_cast<std::uint16_t>((*words)[place].front());
    if (is_pending_[place]) end(place, outcome_of_halt(call_.snapshots()[place], word));
  }
}

/// Waits until the axes in Quick stop active are at rest.
void AxesCommand::await_quick_stops() {
  using namespace literals;
  bool none = true;
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    at_end_[place] = call_.snapshots()[place];
    none = none && (!is_pending_[place] || at_end_[place].state() != PowerState::quick_stop_active);
  }
  if (none) return;
  const std::array option{kObjectRows["quick_stop_option_code"_object].address};
  const auto options = call_.read(option);
  if (!options) return end_all(options.outcome());
  await_each(kQuickStopEnd, call_.tick(), [&](std::size_t place) {
    return quick_stop_ended(call_.snapshots()[place], (*options)[place].front());
  });
}

// ---- several benches -------------------------------------------------------------------------

namespace {

// Number of shares in progress at the same time: their frames must fit into the queues of a bench.
constexpr std::size_t kSharesAtOnce = 8;

/// Axes of one bench that fit in one frame, and their places among all axes.
struct Share {
  std::vector<AxisId> axes;
  std::vector<std::size_t> places;
};

std::vector<Share> shares_of(std::span<const AxisId> axes) {
  std::map<std::uint32_t, std::size_t> open;  // per bench, the share that has room
  std::vector<Share> shares;
  for (std::size_t place = 0; place < axes.size(); ++place) {
    const auto found = open.find(axes[place].bench);
    const bool has_room =
        found != open.end() && shares[found->second].axes.size() < msg::MAX_AXES_PER_FRAME;
    if (!has_room) {
      open[axes[place].bench] = shares.size();
      shares.emplace_back();
    }
    Share& share = shares[open.at(axes[place].bench)];
    share.axes.push_back(axes[place]);
    share.places.push_back(place);
  }
  return shares;
}

template <typename Axes>
std::vector<AxisId> ids_of(const Axes& axes, const auto& id_of) {
  std::vector<AxisId> ids;
  ids.reserve(axes.size());
  for (const auto& axis : axes) ids.push_back(std::invoke(id_of, axis));
  return ids;
}

/// Starts the command in all calls, so that they wait at the same time, not one after the other.
void start_together(std::span<const std::unique_ptr<AxesCommand>> calls) {
  for (const auto& call : calls) call->open();
  for (const auto& call : calls) call->begin();
  bool has_waited = false;
  for (const auto& call : calls) {
    if (has_waited) call->refresh();
    has_waited = call->await_before() || has_waited;
  }
  if (calls.size() > 1) {
    for (const auto& call : calls) call->refresh();
  }
  for (const auto& call : calls) call->send();
  std::set<std::uint32_t> stepped;
  for (const auto& call : calls) call->await_in_force(stepped);
  for (const auto& call : calls) call->close_unless_pending();
}

}  // namespace

std::vector<Outcome> command_each(const std::shared_ptr<SessionCore>& core,
                                  std::span<const AxisId> axes, EachCommand command,
                                  const CallOptions& options) {
  const std::vector<Share> shares = shares_of(axes);
  std::vector<std::unique_ptr<AxesCommand>> calls;
  calls.reserve(shares.size());
  while (calls.size() < shares.size()) {
    const std::size_t first = calls.size();
    const std::size_t count = std::min(kSharesAtOnce, shares.size() - first);
    for (const Share& share : std::span(shares).subspan(first, count)) {
      calls.push_back(std::make_unique<AxesCommand>(core, layout_of(share.axes), Caller::axis,
                                                    command, options));
    }
    start_together(std::span(calls).subspan(first));
  }
  for (const auto& call : calls) call->finish();
  std::vector<Outcome> outcomes(axes.size());
  // From last to first: calls that stop axes and survive an interrupt must end in reverse order.
  while (!calls.empty()) {
    const Share& share = shares[calls.size() - 1];
    for (std::size_t i = 0; i < share.places.size(); ++i) {
      outcomes[share.places[i]] = calls.back()->outcomes()[i];
    }
    calls.pop_back();
  }
  explain_losses(*core, outcomes, axes);
  return outcomes;
}

std::vector<Outcome> Session::command_each(std::span<const Axis> axes, EachCommand command,
                                           const CallOptions& options) {
  return client::command_each(core_, ids_of(axes, &Axis::id), command, options);
}

Outcome Session::quick_stop(std::uint32_t bench, const CallOptions& options) {
  const Wakeup::StopInProgress in_progress(core_->wakeup);
  const auto found = core_->discovery.find_bench(bench);
  if (!found) return found.outcome();
  AxesCommand stop(core_, layout_of(ids_of(found->info.axes, &AxisInfo::id)), Caller::group,
                   EachCommand::quick_stop, options);
  stop.begin();
  if (Outcome begun = stop.outcome(); !begun) return begun;
  const Target& target = stop.call().axes().parts().front().target;
  if (core_->discovery.is_paused(target.key)) return Outcome::failed(paused_text(target));
  stop.carry_out();
  return stop.outcome();
}

}  // namespace vdrive::client
