// SPDX-License-Identifier: Apache-2.0
#include "calls/each_axis.hpp"

#include "base/ask.hpp"
#include "base/command_objects.hpp"
#include "base/command_words.hpp"
#include "calls/arrival.hpp"
#include "calls/lost_control.hpp"
#include "calls/slow_drive.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace vdrive::client {

struct EachCommandRow {
  EachCommand command;
  bool is_stop;                   ///< also acts on axes of other sessions
  std::string_view name;          ///< in a refusal
  std::string_view needs;         ///< what has to be done before
  bool (*can_take)(PowerState);   ///< else it is refused
  bool (*is_at_end)(PowerState);  ///< nothing is left to do
};

namespace {

constexpr std::string_view kOperationEnabled = "Operation enabled";
constexpr std::string_view kResetFirst = "a fault reset first";
constexpr std::string_view kQuickStopEnd = "the quick stop to end";
constexpr std::string_view kStandstill = "standstill, bit 10";

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

constexpr std::array kRows{
    EachCommandRow{EachCommand::enable, false, "enabling", kResetFirst, without_fault,
                   in_operation},
    EachCommandRow{EachCommand::disable, false, "disabling", kResetFirst, without_fault,
                   in_no_state},
    EachCommandRow{EachCommand::halt, true, "a halt", kOperationEnabled, in_operation, in_no_state},
    EachCommandRow{EachCommand::resume, false, "resuming", kOperationEnabled, in_operation,
                   in_no_state},
    EachCommandRow{EachCommand::quick_stop, true, "a quick stop", kResetFirst, without_fault,
                   in_no_state},
    EachCommandRow{EachCommand::reset_fault, false, "", "", in_every_state, without_fault},
    EachCommandRow{EachCommand::power_cycle, false, "", "", in_every_state, in_no_state}};

const EachCommandRow& row_of(EachCommand command) {
  const auto* const row = std::ranges::find(kRows, command, &EachCommandRow::command);
  ensure(row != kRows.end(), "every command has a row");
  return *row;
}

GroupLayout layout_of_bench(std::span<const AxisId> axes) {
  GroupLayout layout{.axes = {axes.begin(), axes.end()},
                     .benches = {{.number = axes.front().bench, .axes = {}, .places = {}}}};
  GroupLayout::Bench& bench = layout.benches.front();
  for (std::size_t place = 0; place < axes.size(); ++place) {
    bench.axes.push_back(axes[place].axis);
    bench.places.push_back(place);
  }
  return layout;
}

/// @return the controlwords that carry the command out from `state`.
std::vector<std::uint16_t> words_of(EachCommand command, PowerState state) {
  switch (command) {
    case EachCommand::enable: {
      const auto words = enabling_words(state);
      return {words.begin(), words.end()};
    }
    case EachCommand::disable:
      // Where 605Ah keeps the state after a quick stop.
      if (state == PowerState::quick_stop_active) return {kDisableVoltage, kShutdown};
      return {kShutdown};
    case EachCommand::resume:
      return {kEnableOperation};
    case EachCommand::reset_fault:
      return reset_words();
    case EachCommand::halt:
      return {kHalt};
    case EachCommand::quick_stop:
      return {kQuickStop};
    case EachCommand::power_cycle:
      break;
  }
  return {};
}

}  // namespace

EachAxis::EachAxis(std::shared_ptr<SessionCore> core, std::span<const AxisId> axes,
                   EachCommand command, const CallOptions& options)
    : core_(core),
      call_(std::move(core), layout_of_bench(axes), Caller::axis),
      row_(row_of(command)),
      options_(options),
      outcomes_(axes.size()),
      is_pending_(axes.size(), true),
      at_end_(axes.size()) {
  if (row_.is_stop) stop_.emplace(*core_, call_);
}

void EachAxis::open() {
  if (Outcome opened = call_.open(); !opened) end_all(opened);
}

void EachAxis::begin() {
  if (!has_pending()) return;
  if (Outcome begun = begin_call(); !begun) return end_all(begun);
  judge();
  if (has_pending()) await_before();
}

void EachAxis::refresh() {
  if (!has_pending()) return;
  if (Outcome seen = call_.axes().refresh(); !seen) return end_all(seen);
  judge();
}

void EachAxis::send() {
  if (has_pending() && goes_by_frames()) call_.begin_to_put_in_force(rounds());
}

void EachAxis::await_in_force(std::set<std::uint32_t>& stepped) {
  if (!has_pending()) return;
  const std::uint32_t bench = call_.axes().layout().axes.front().bench;
  const Outcome done = goes_by_frames() ? call_.await_in_force(stepped.contains(bench))
                       : stop_          ? stop()
                                        : power_cycle();
  if (!done) return end_all(done);
  if (goes_by_frames()) stepped.insert(bench);
  judge_in_force();
}

void EachAxis::close_unless_pending() {
  if (!has_pending()) call_.axes().close();
}

void EachAxis::finish() {
  if (!has_pending() || options_.until == Until::in_force) return;
  switch (row_.command) {
    case EachCommand::enable:
      return await_operation();
    case EachCommand::reset_fault:
      return await_reset();
    case EachCommand::disable:
      return await_state(PowerState::ready_to_switch_on);
    case EachCommand::power_cycle:
      return await_state(PowerState::switch_on_disabled);
    case EachCommand::halt:
      return await_standstill();
    case EachCommand::resume:
      return await_targets();
    case EachCommand::quick_stop:
      if (const Outcome seen = await_stop_seen(call_); !seen) return end_all(seen);
      await_quick_stops();
      return fail_unless(kQuickStopEnd, has_no_fault);
    default:
      return;
  }
}

// ---- outcomes --------------------------------------------------------------------------------

void EachAxis::end(std::size_t place, Outcome outcome) {
  outcomes_[place] = std::move(outcome);
  is_pending_[place] = false;
}

void EachAxis::end_all(const Outcome& outcome) {
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (is_pending_[place]) end(place, outcome);
  }
}

std::vector<std::size_t> EachAxis::pending_places() const {
  std::vector<std::size_t> places;
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (is_pending_[place]) places.push_back(place);
  }
  return places;
}

bool EachAxis::has_pending() const {
  return std::ranges::find(is_pending_, true) != is_pending_.end();
}

/// Ends the axes that did not come to what was awaited.
void EachAxis::fail_unless(std::string_view awaited, bool (*holds)(const AxisSnapshot&)) {
  std::optional<Outcome> service;  // asked once
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (!is_pending_[place] || holds(at_end_[place])) continue;
    Outcome failed = failed_instead_of(awaited, at_end_[place]);
    if (!service && has_no_fault(at_end_[place])) service = call_.check_service(at_end_[place]);
    const bool has_ended = service && !*service;
    end(place,
        has_ended ? service->with_message(service->message() + "; " + failed.message()) : failed);
  }
}

// ---- start -----------------------------------------------------------------------------------

Outcome EachAxis::begin_call() {
  if (stop_) return stop_->begin(options_.timeout);
  if (Outcome begun = call_.begin(options_.timeout); !begun) return begun;
  return row_.command == EachCommand::power_cycle ? Outcome() : acquire();
}

/// All at once, or one by one where another session owns some of them.
Outcome EachAxis::acquire() {
  constexpr std::uint32_t kLocalControl = wire_code(AbortCode::refused_local_control);
  Outcome taken = call_.acquire();
  if (taken || taken.code() != kLocalControl || outcomes_.size() == 1) return taken;
  const BenchPart& part = call_.axes().parts().front();
  for (std::size_t place = 0; place < outcomes_.size(); ++place) {
    Outcome own = core_->control.acquire(part.target, {&call_.snapshots()[place].id.axis, 1});
    if (!own) end(place, core_->names.named(part.target, std::move(own)));
  }
  return {};
}

bool EachAxis::refuses_any() const {
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    const PowerState state = call_.snapshots()[place].state();
    if (is_pending_[place] && !row_.is_at_end(state) && !row_.can_take(state)) return true;
  }
  return false;
}

void EachAxis::judge() {
  if (refuses_any()) {
    if (Outcome seen = call_.axes().look_again(); !seen) return end_all(seen);
  }
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    const AxisSnapshot& axis = call_.snapshots()[place];
    if (!is_pending_[place]) continue;
    if (row_.is_at_end(axis.state())) {
      end(place, {});
    } else if (!row_.can_take(axis.state())) {
      end(place, refused_in_state(axis, row_.name, row_.needs));
    }
  }
}

void EachAxis::await_before() {
  const bool enables_at_once =
      row_.command == EachCommand::enable && options_.until == Until::in_force;
  if (row_.command == EachCommand::reset_fault) {
    await_each("the fault reaction to end", call_.tick(), [this](std::size_t place) {
      return call_.snapshots()[place].state() != PowerState::fault_reaction_active;
    });
  } else if (row_.command == EachCommand::disable ||
             (row_.command == EachCommand::enable && !enables_at_once)) {
    await_quick_stops();
  }
}

bool EachAxis::goes_by_frames() const {
  return !stop_ && row_.command != EachCommand::power_cycle;
}

/// The n-th round has the n-th word of each axis.
std::vector<Round> EachAxis::rounds() const {
  std::vector<Round> rounds;
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (!is_pending_[place]) continue;
    const auto words = words_of(row_.command, call_.snapshots()[place].state());
    rounds.resize(std::max(rounds.size(), words.size()));
    for (std::size_t i = 0; i < words.size(); ++i) {
      msg::AxisCommand command = call_.command_to(place);
      if (row_.command == EachCommand::enable) {
        add_enabling_word(command, words[i], options_.keep_target);
      } else {
        add_word(command, words[i]);
      }
      rounds[i].entries.push_back({place, std::move(command)});
    }
  }
  return rounds;
}

Outcome EachAxis::stop() {
  if (row_.command == EachCommand::halt) {
    if (Outcome taken = stop_->acquire_free(); !taken) return taken;
  }
  return stop_->put_in_force(rounds().front());
}

/// All at once, or one by one where another session owns some of them.
Outcome EachAxis::power_cycle() {
  const Target& target = call_.axes().parts().front().target;
  std::vector<std::uint16_t> axes;
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (is_pending_[place]) axes.push_back(call_.snapshots()[place].id.axis);
  }
  const auto cycle = [&](const std::vector<std::uint16_t>& some) {
    return core_->control.exchange(
        target, ask::power_cycle(some),
        "power cycle of " +
            (some.size() == 1 ? name_of(target, some.front()) : "axes of " + name_of(target)));
  };
  const auto reply = cycle(axes);
  if (reply) {
    // The tick of this call still shows the axes before it.
    from_ = std::max(reply->tick, call_.tick() + 1);
    call_.note_in_force(from_);
    return {};
  }
  if (axes.size() == 1 || reply.outcome().kind() != OutcomeKind::refused) {
    return core_->names.named(target, reply.outcome());
  }
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (!is_pending_[place]) continue;
    const auto own = cycle({call_.snapshots()[place].id.axis});
    if (own) {
      from_ = std::max({from_, own->tick, call_.tick() + 1});
      call_.note_in_force(from_);
    } else {
      end(place, core_->names.named(target, own.outcome()));
    }
  }
  return {};
}

/// What is done in the tick in which the words are in force, as nearly every drive does it.
void EachAxis::judge_in_force() {
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (!is_pending_[place]) continue;
    const AxisSnapshot& axis = call_.snapshots()[place];
    if (row_.command == EachCommand::enable) {
      judge_enabling(place);
    } else if (row_.command == EachCommand::reset_fault) {
      if (has_no_fault(axis)) end(place, {});
      if (options_.until == Until::in_force) end_faulty(place);
    }
  }
}

/// In Switched on power is on its way.
void EachAxis::judge_enabling(std::size_t place) {
  const AxisSnapshot& axis = call_.snapshots()[place];
  if (is_enabled(axis)) return end(place, {});
  if (options_.until == Until::done) return;
  const bool is_on_its_way = axis.state() == PowerState::switched_on;
  end(place, is_on_its_way ? Outcome() : failed_instead_of(kOperationEnabled, axis));
}

/// Ends the axis at `place`, unless it has ended, where its fault is still there.
void EachAxis::end_faulty(std::size_t place) {
  const AxisSnapshot& axis = call_.snapshots()[place];
  if (!is_pending_[place] || has_no_fault(axis)) return;
  const Outcome still = failed_instead_of("the end of the fault", axis);
  end(place, not_in_this_state(still.message() + ", the cause persists"));
}

// ---- finish ----------------------------------------------------------------------------------

/// Waits until every axis that is pending was `done` once, at `from` or later; ends those that were
/// not.
template <typename Done>
void EachAxis::await_each(std::string_view awaited, std::uint64_t from, const Done& done) {
  std::vector<bool> has_come(is_pending_.size(), false);
  const Outcome seen = call_.await(awaited, from, [&](std::size_t place) {
    if (has_come[place] || !is_pending_[place]) return true;
    if (call_.tick() < from || !done(place)) return false;
    has_come[place] = true;
    at_end_[place] = call_.snapshots()[place];
    return true;
  });
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (!is_pending_[place] || has_come[place]) continue;
    const bool is_late = seen.kind() == OutcomeKind::timed_out && outcomes_.size() > 1;
    end(place, is_late ? timed_out_for(awaited, call_.snapshots()[place]) : seen);
  }
}

void EachAxis::await_state(PowerState state) {
  await_each(to_string(state), std::max(from_, call_.tick()), [this, state](std::size_t place) {
    const PowerState present = call_.snapshots()[place].state();
    return present == state || is_fault(present);
  });
  fail_unless(to_string(state), has_no_fault);
}

void EachAxis::await_operation() {
  const auto await_each_answer = [this] {
    const AnswerTime answer_time(call_, kLongestLoop);
    await_each(kOperationEnabled, call_.tick(), [&](std::size_t place) {
      return has_answered_enabling(call_.snapshots()[place], answer_time);
    });
  };
  await_each_answer();
  const auto walked = walk_to_operation(call_, pending_places());
  if (!walked) return end_all(walked.outcome());
  if (*walked) await_each_answer();
  fail_unless(kOperationEnabled, is_enabled);
}

void EachAxis::await_reset() {
  const AnswerTime answer_time(call_, kLongestReset);
  await_each("the end of the fault", call_.tick(), [&](std::size_t place) {
    return answer_time.has_ended() || has_no_fault(call_.snapshots()[place]);
  });
  std::vector<std::size_t> faulty;
  for (std::size_t place = 0; place < is_pending_.size(); ++place) {
    if (is_pending_[place] && is_fault(call_.snapshots()[place].state())) faulty.push_back(place);
  }
  if (faulty.empty()) return;
  const Outcome held = hold_reset(call_, faulty);
  for (const std::size_t place : faulty) {
    if (held) {
      end_faulty(place);
    } else {
      end(place, held);
    }
  }
}

void EachAxis::await_standstill() {
  await_each(kStandstill, call_.tick(), [this](std::size_t place) {
    const AxisSnapshot& axis = call_.snapshots()[place];
    return !is_enabled(axis) || stands_still(axis);
  });
  fail_unless(kStandstill, is_enabled);
}

/// After a halt an axis continues to its target, or is halted again.
void EachAxis::await_targets() {
  std::vector<Outcome> sound(outcomes_.size());
  await_each(kTargetReached, call_.tick(), [&](std::size_t place) {
    sound[place] = call_.check_command(kTargetReached, place);
    return !sound[place] || has_no_way_left(call_.snapshots()[place]);
  });
  const bool is_interrupted = core_->wakeup.is_interrupted();
  for (std::size_t place = 0; place < outcomes_.size(); ++place) {
    const bool goes_on = is_interrupted && outcomes_[place].kind() == OutcomeKind::failed;
    if (goes_on && is_enabled(call_.snapshots()[place])) {
      outcomes_[place] = goes_on_to_target(call_.snapshots()[place]);
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

/// Lets the axes in Quick stop active come to rest.
void EachAxis::await_quick_stops() {
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

// Shares that are on the way at a time: their frames fit into the queues of a bench.
constexpr std::size_t kSharesAtOnce = 8;

/// Axes of one bench that fit into a frame, by their places among all axes.
struct Share {
  std::vector<AxisId> axes;
  std::vector<std::size_t> places;
};

std::vector<Share> shares_of(std::span<const AxisId> axes) {
  std::map<std::uint32_t, std::size_t> open;  // the share of a bench that has room
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

/// Gives the command to all of them: each waits while the others do, and not behind them.
void start_together(std::span<const std::unique_ptr<EachAxis>> calls) {
  for (const auto& call : calls) call->open();
  for (const auto& call : calls) call->begin();
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
  std::vector<std::unique_ptr<EachAxis>> calls;
  calls.reserve(shares.size());
  while (calls.size() < shares.size()) {
    const std::size_t first = calls.size();
    const std::size_t count = std::min(kSharesAtOnce, shares.size() - first);
    for (const Share& share : std::span(shares).subspan(first, count)) {
      calls.push_back(std::make_unique<EachAxis>(core, share.axes, command, options));
    }
    start_together(std::span(calls).subspan(first));
  }
  for (const auto& call : calls) call->finish();
  std::vector<Outcome> outcomes(axes.size());
  // From the last to the first: calls that stop axes survive an interrupt one within the other.
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

}  // namespace vdrive::client
