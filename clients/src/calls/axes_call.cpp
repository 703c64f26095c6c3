// SPDX-License-Identifier: Apache-2.0
#include "calls/axes_call.hpp"

#include "base/ask.hpp"
#include "base/drive_words.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// How long, in wall time, the call of an axis waits for other steppers before it checks its
// time-out.
constexpr milliseconds kStepperPatience{500};

// How far ahead a frame is sent for a tick shared by several benches. If a bench is so busy that it
// refuses the frame as too late, the next attempt uses a longer lead.
constexpr milliseconds kFirstMargin{20};
constexpr int kMarginGrowth = 4;
constexpr int kAttempts = 4;

// Longer than any stop with the default ramps.
constexpr std::chrono::seconds kStopTime{5};

std::vector<msg::Request> read_requests(const GroupLayout::Bench& bench,
                                        std::span<const ObjectAddress> objects) {
  const std::size_t axes_a_request = msg::MAX_OBJECTS_PER_REQUEST / objects.size();
  std::vector<msg::Request> requests;
  for (std::size_t i = 0; i < bench.axes.size(); ++i) {
    if (i % axes_a_request == 0) requests.push_back(ask::read({}));
    for (const ObjectAddress& object : objects) {
      requests.back().objects.push_back(ask::object(bench.axes[i], object));
    }
  }
  return requests;
}

/// @return the frames with commands to axes of this bench.
std::vector<FrameContent> frames_of(std::span<const Round> rounds, const BenchPart& part,
                                    const GroupLayout& layout, std::uint64_t apply_at) {
  std::vector<FrameContent> frames;
  for (const Round& round : rounds) {
    FrameContent frame{.commands = {}, .apply_at_tick = apply_at, .flags = round.flags};
    for (const Round::Entry& entry : round.entries) {
      if (layout.axes[entry.place].bench != part.bench->number) continue;
      frame.commands.push_back(entry.command);
      if (round.is_endless) frame.moved.push_back(entry.command.axis);
    }
    if (!frame.commands.empty()) frames.push_back(std::move(frame));
  }
  return frames;
}

void note_ignored(const GroupLayout::Bench& bench, std::span<const std::uint16_t> axes,
                  Answers& answers) {
  for (std::size_t i = 0; i < bench.axes.size(); ++i) {
    if (std::ranges::find(axes, bench.axes[i]) != axes.end()) {
      answers.ignored.push_back(bench.places[i]);
    }
  }
}

}  // namespace

Outcome not_in_this_state(std::string message) {
  return Outcome::refused(wire_code(AbortCode::refused_in_present_device_state),
                          std::move(message));
}

Outcome refused_in_state(const AxisSnapshot& axis, std::string_view command,
                         std::string_view hint) {
  // For a fault, give its cause, as failed_instead_of() does.
  const std::string present = is_fault(axis.state())
                                  ? what_it_shows(axis) + "; "
                                  : "is in " + std::string(to_string(axis.state())) + ", ";
  return not_in_this_state("axis " + to_string(axis.id) + " " + present + std::string(command) +
                           " needs " + std::string(hint));
}

Outcome failed_instead_of(std::string_view awaited, const AxisSnapshot& axis) {
  return Outcome::failed("axis " + to_string(axis.id) + " " + what_it_shows(axis) +
                         "; waited for " + std::string(awaited));
}

Outcome timed_out_for(std::string_view awaited, const AxisSnapshot& axis) {
  return Outcome::timed_out("axis " + to_string(axis.id) + ": timed out while waiting for " +
                            std::string(awaited) + ", " + what_it_shows(axis));
}

AxesCall::AxesCall(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
                   ObservedAxes::Progress progress)
    : core_(core),
      axes_(std::move(core), std::move(layout), caller, std::move(progress)),
      was_owner_(axes_.layout().axes.size()),
      given_(axes_.layout().axes.size()),
      is_superseded_(axes_.layout().axes.size()) {}

// ---- begin -----------------------------------------------------------------------------------

Outcome AxesCall::begin(std::chrono::nanoseconds timeout) {
  if (Outcome connected = axes_.connect(); !connected) return connected;
  set_timeout(timeout);
  return {};
}

void AxesCall::set_timeout(std::chrono::nanoseconds timeout) {
  timeout_ = timeout;
  deadline_ = driven_tick() + ticks_of(timeout, period());
}

void AxesCall::note_in_force(std::uint64_t tick) {
  if (axes_.parts().front().target.clock_mode != ClockMode::freerun) return;
  deadline_ = std::max(deadline_, tick + ticks_of(timeout_, period()));
}

std::string AxesCall::position_text(std::int64_t user_units) const {
  return quantity_text(user_units, Dimension::position, unit_of(snapshot().id));
}

std::string AxesCall::velocity_text(std::int64_t user_units) const {
  return quantity_text(user_units, Dimension::velocity, unit_of(snapshot().id));
}

Outcome AxesCall::require(bool (*fulfils)(const AxisSnapshot& axis), std::string_view command,
                          std::string_view needs) {
  const auto offender = [&] {
    return std::ranges::find_if_not(snapshots(), fulfils);
  };
  if (offender() == snapshots().end()) return {};
  if (Outcome seen = axes_.look_again(); !seen) return seen;
  return offender() == snapshots().end() ? Outcome()
                                         : refused_in_state(*offender(), command, needs);
}

/// Without the axes that the session already has: acquiring one again would end the earlier
/// commands to it.
std::vector<std::uint16_t> AxesCall::axes_to_acquire(const BenchPart& part) const {
  std::vector<std::uint16_t> axes;
  for (const AxisSnapshot& axis : part.seen.axes) {
    if (!has_control_of(part.target, axis)) axes.push_back(axis.id.axis);
  }
  return axes;
}

Outcome AxesCall::acquire(bool by_force) {
  for (BenchPart& part : axes_.parts()) {
    if (!core_->links.may_command()) return not_permitted(part.target);
    if (axes_.caller() == Caller::axis && core_->discovery.is_paused(part.target.key)) {
      return Outcome::failed(paused_text(part.target));
    }
    const std::vector<std::uint16_t> axes = axes_to_acquire(part);
    if (axes.empty()) continue;
    if (Outcome taken = core_->control.acquire(part.target, axes, by_force); !taken) {
      return core_->names.with_session_name(part.target, axes_.note_lost(part, std::move(taken)));
    }
  }
  return {};
}

Outcome AxesCall::begin_control(std::chrono::nanoseconds timeout,
                                std::span<const ObjectAddress> objects) {
  if (Outcome begun = begin(timeout); !begun) return begun;
  if (!objects.empty()) ask(objects);
  return acquire();
}

// ---- observing ---------------------------------------------------------------------------------

std::string AxesCall::read_name(const BenchPart& part) const {
  const bool is_one = axes_.caller() == Caller::axis && snapshots().size() == 1;
  return is_one ? "axis " + to_string(snapshot().id) : "axes of " + name_of(part.target);
}

void AxesCall::ask(std::span<const ObjectAddress> objects) {
  asked_.clear();
  asked_objects_ = objects.size();
  for (const BenchPart& part : axes_.parts()) {
    asked_.push_back(core_->exchange.send_all(part.target, read_requests(*part.bench, objects)));
  }
}

Result<AxesCall::Values> AxesCall::read(std::span<const ObjectAddress> objects) {
  ask(objects);
  return take_values();
}

Result<AxesCall::Values> AxesCall::take_values() {
  ensure(asked_.size() == axes_.parts().size(), "values are taken once, after they were asked for");
  Values values(snapshots().size());
  auto asked = asked_.begin();
  for (BenchPart& part : axes_.parts()) {
    const auto replies = asked++->await("read of " + read_name(part));
    if (!replies) return axes_.note_lost(part, replies.outcome());
    std::vector<msg::ObjectResult> results;
    for (const msg::Reply& reply : *replies) {
      results.insert(results.end(), reply.objects.begin(), reply.objects.end());
    }
    if (results.size() != part.bench->axes.size() * asked_objects_) {
      return Outcome::failed(axes_.caller() == Caller::axis
                                 ? "the read of " + read_name(part) + " was answered only in part"
                                 : name_of(part.target) + " answered the read only in part");
    }
    for (std::size_t i = 0; i < results.size(); ++i) {
      if (results[i].abort_code != msg::Reason::none) {
        return Outcome::refused(wire::number(results[i].abort_code),
                                "read of " + name_of(part.target, results[i].axis) + " refused");
      }
      values[part.bench->places[i / asked_objects_]].push_back(results[i].value);
    }
  }
  return values;
}

// ---- commands --------------------------------------------------------------------------------

msg::AxisCommand AxesCall::command_to(std::size_t place) const {
  msg::AxisCommand command;
  command.axis = axes_.layout().axes[place].axis;
  return command;
}

Answers AxesCall::exchange(std::span<const Round> rounds, Timing timing) {
  if (timing == Timing::at_once || axes_.parts().size() == 1 || steps()) {
    return exchange_at(rounds, 0);
  }
  milliseconds margin = kFirstMargin;
  for (int attempt = 1;; ++attempt) {
    const auto newest = axes_.newest_tick();
    if (!newest) return {newest.outcome(), 0, {}};
    Answers answers = exchange_at(rounds, *newest + ticks_of(margin, period()));
    const bool untouched =
        answers.outcome.code() == wire::number(msg::Reason::too_late) && answers.tick == 0;
    if (!untouched || attempt == kAttempts) return answers;
    margin *= kMarginGrowth;
  }
}

Answers AxesCall::exchange_at(std::span<const Round> rounds, std::uint64_t apply_at) {
  std::vector<SentFrames> sent;
  Outcome outcome = send(rounds, apply_at, sent);
  if (outcome && apply_at != 0) {
    // A refusal arrives before the tick: there is still time to cancel on the other benches.
    const auto accepted = core_->exchange.await_answers(sent);
    if (!accepted || !*accepted) cancel_pending();
  }
  return collect(sent, std::move(outcome));
}

Outcome AxesCall::put_in_force(std::span<const Round> rounds) {
  begin_to_put_in_force(rounds);
  return await_in_force();
}

void AxesCall::begin_to_put_in_force(std::span<const Round> rounds) {
  sent_.clear();
  sending_ = send(rounds, 0, sent_);
}

Outcome AxesCall::await_in_force(bool has_stepped) {
  // In lock-step the answer arrives with a tick, which this session itself must step.
  if (sending_ && steps()) sending_ = axes_.advance(has_stepped ? 0 : 1);
  Answers answers = collect(sent_, std::move(sending_));
  if (!answers.outcome) return answers.outcome;
  if (!answers.ignored.empty()) {
    return not_in_this_state("axis " + to_string(snapshots()[answers.ignored.front()].id) +
                             " ignored the set-point because its buffer is full");
  }
  return steps() ? Outcome() : await_tick("the command to take effect", answers.tick);
}

Outcome AxesCall::put_in_force(const std::vector<std::uint16_t>& controlwords) {
  std::vector<Round> rounds;
  rounds.reserve(controlwords.size());
  for (const std::uint16_t word : controlwords) rounds.push_back(round_of(word, every_axis));
  return put_in_force(rounds);
}

Outcome AxesCall::send(std::span<const Round> rounds, std::uint64_t apply_at,
                       std::vector<SentFrames>& sent) {
  const std::vector<BenchPart>& parts = axes_.parts();
  for (const BenchPart& part : parts) sent.push_back({.target = part.target, .sequences = {}});
  const auto send_to = [&](std::size_t i, std::span<const Round> some) -> Outcome {
    const auto frames = frames_of(some, parts[i], axes_.layout(), apply_at);
    if (frames.empty() || parts[i].is_lost()) return {};
    const std::size_t before = sent[i].sequences.size();
    Outcome outcome = core_->exchange.send(sent[i], frames);
    note_given(parts[i], some, std::span(sent[i].sequences).subspan(before));
    return outcome;
  };
  // With a single bench, all frames are sent together, without a frame of another thread in
  // between.
  if (parts.size() == 1) return send_to(0, rounds);
  // With several benches, none gets a round before all have the previous one: if a bench cannot be
  // reached, the others must not start.
  for (const Round& round : rounds) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (Outcome outcome = send_to(i, {&round, 1}); !outcome) return outcome;
    }
  }
  return {};
}

/// @param sequences of the frames that were sent to this bench for `rounds`
void AxesCall::note_given(const BenchPart& part, std::span<const Round> rounds,
                          std::span<const std::uint64_t> sequences) {
  auto sequence = sequences.begin();
  for (const Round& round : rounds) {
    bool has_frame = false;
    for (const Round::Entry& entry : round.entries) {
      if (axes_.layout().axes[entry.place].bench != part.bench->number) continue;
      if (sequence == sequences.end()) return;
      note_given(entry.place, entry.command, *sequence);
      has_frame = true;
    }
    if (has_frame) ++sequence;
  }
}

void AxesCall::note_given(std::size_t place, const msg::AxisCommand& command,
                          std::uint64_t sequence) {
  GivenCommand& given = given_[place];
  const bool is_first = given.sequence == 0;
  if (!is_first && !ends_motion(command)) return;
  if ((command.members & msg::HAS_OP_MODE_CMD) != 0) {
    given.mode = static_cast<OperatingMode>(command.op_mode_cmd);
  } else if (is_first) {
    given.mode = snapshots()[place].mode();
  }
  given.sequence = sequence;
}

void AxesCall::follow(std::vector<GivenCommand> given) {
  note_owned();
  given_ = std::move(given);
}

/// Cancels the frames that still wait on the other benches after one bench has refused.
void AxesCall::cancel_pending() {
  const FrameContent cancel{.commands = {}, .flags = msg::FRAME_CANCEL_PENDING};
  for (const BenchPart& part : axes_.parts()) {
    SentFrames sent{.target = part.target, .sequences = {}};
    Outcome outcome = core_->exchange.send(sent, {&cancel, 1});
    // The answers to the cancelled frames report the outcome.
    (void)core_->exchange.collect(sent, std::move(outcome));
  }
}

Answers AxesCall::collect(std::span<const SentFrames> sent, Outcome outcome) {
  Answers answers{std::move(outcome), 0, {}};
  const bool wait = static_cast<bool>(answers.outcome);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (sent[i].sequences.empty()) continue;
    BenchPart& part = axes_.parts()[i];
    auto applied = core_->exchange.collect(sent[i], wait ? Outcome() : answers.outcome);
    applied.outcome = axes_.note_lost(part, std::move(applied.outcome));
    // A cancelled frame is only the effect of another refusal, which names the cause.
    if (!applied.outcome &&
        (answers.outcome || answers.outcome.code() == wire::number(msg::Reason::cancelled))) {
      answers.outcome = applied.outcome;
    }
    answers.tick = std::max(answers.tick, applied.tick);
    note_ignored(*part.bench, applied.ignored_set_points, answers);
  }
  note_in_force(answers.tick);
  return answers;
}

// ---- waiting ---------------------------------------------------------------------------------

/// The time-out counts drive time, which may pass more slowly than wall time. If it does not pass
/// at all, the time-out of a call for one axis counts wall time.
Outcome AxesCall::observe_next(std::string_view awaited, std::span<const std::size_t> late) {
  if (driven_tick() >= deadline_) return timed_out(awaited, late);
  if (axes_.caller() == Caller::group) return axes_.advance(1);
  const auto begin = std::chrono::steady_clock::now();
  while (true) {
    Outcome seen = axes_.advance(1, kStepperPatience);
    if (seen.kind() != OutcomeKind::timed_out) return seen;
    if (std::chrono::steady_clock::now() - begin >= timeout_) {
      return Outcome::timed_out("axis " + to_string(snapshot().id) +
                                ": timed out while waiting for " + std::string(awaited) + ", " +
                                seen.message());
    }
  }
}

Outcome AxesCall::timed_out(std::string_view awaited, std::span<const std::size_t> late) const {
  if (axes_.caller() == Caller::axis) return timed_out_for(awaited, snapshot());
  std::string message = "timed out while waiting for " + std::string(awaited);
  for (std::size_t i = 0; i < std::min(late.size(), kMostNamed); ++i) {
    const AxisSnapshot& axis = snapshots()[late[i]];
    message +=
        (i == 0 ? " of axis " : "; axis ") + to_string(axis.id) + ", which " + what_it_shows(axis);
  }
  if (late.size() > kMostNamed) {
    message += "; and " + std::to_string(late.size() - kMostNamed) + " more";
  }
  return Outcome::timed_out(std::move(message));
}

Outcome AxesCall::await_tick(std::string_view awaited, std::uint64_t tick) {
  return await(awaited, tick, every_axis);
}

// ---- checks ------------------------------------------------------------------------------------

bool AxesCall::is_taken(std::size_t place) const {
  const std::uint64_t owner = snapshots()[place].owner_session;
  return was_owner_[place] && owner != 0 && owner != core_->id;
}

Outcome AxesCall::check_owners() {
  for (std::size_t place = 0; place < snapshots().size(); ++place) {
    const AxisSnapshot& axis = snapshots()[place];
    if (axis.owner_session == core_->id) was_owner_[place] = true;
    if (!is_taken(place)) continue;
    const std::string what = axes_.caller() == Caller::axis
                                 ? "the axis: this call ends and does not stop it"
                                 : "an axis of the group: this call ends and stops the others";
    return Outcome::refused(wire::number(msg::Reason::not_owner),
                            "another session has taken " + what)
        .with_owner({.axis = axis.id, .session = axis.owner_session});
  }
  return {};
}

const BenchPart& AxesCall::part_of(const AxisId& axis) const {
  return *std::ranges::find_if(axes_.parts(), [&axis](const BenchPart& part) {
    return part.bench->number == axis.bench;
  });
}

std::optional<std::string> AxesCall::find_end(std::size_t place) const {
  if (given_[place].sequence == 0) return std::nullopt;
  const AxisSnapshot& axis = snapshots()[place];
  return core_->history.find_end(part_of(axis.id).target.key, given_[place], axis);
}

Outcome AxesCall::check_command(std::string_view awaited, std::size_t place) {
  const AxisSnapshot& axis = snapshots()[place];
  const auto end = find_end(place);
  if (is_enabled(axis) && !end) return {};
  if (!is_enabled(axis)) {
    const Outcome failed = failed_instead_of(awaited, axis);
    return end ? failed.with_message(failed.message() + "; superseded by " + *end) : failed;
  }
  is_superseded_[place] = true;
  return Outcome::failed("axis " + to_string(axis.id) + ": superseded by " + *end +
                         "; waited for " + std::string(awaited));
}

bool AxesCall::is_superseded() const {
  return std::ranges::find(is_superseded_, true) != is_superseded_.end();
}

Outcome AxesCall::check(std::string_view awaited, std::uint64_t from) {
  // The owners first, because they must be recorded in each tick, even before `from`.
  Outcome own = check_owners();
  if (tick() < from) return {};
  if (!own) return axes_.caller() == Caller::axis ? own : stop_others(std::move(own));
  for (std::size_t place = 0; place < snapshots().size(); ++place) {
    Outcome sound = check_command(awaited, place);
    if (sound) continue;
    const AxisSnapshot axis = snapshots()[place];
    Outcome stopped = stop_others(std::move(sound));
    return explain_lost_power(stopped, axis);
  }
  return {};
}

Outcome AxesCall::explain_lost_power(const Outcome& failed) {
  const auto off = std::ranges::find_if_not(snapshots(), is_enabled);
  return off == snapshots().end() ? failed : explain_by_service(failed, *off);
}

Outcome AxesCall::explain_lost_power(const Outcome& failed, const AxisSnapshot& axis) {
  return is_enabled(axis) ? failed : explain_by_service(failed, axis);
}

Outcome AxesCall::explain_by_service(const Outcome& failed, const AxisSnapshot& axis) {
  const Outcome service = check_service(axis);
  return service ? failed : service.with_message(service.message() + "; " + failed.message());
}

/// A service that is shutting down answers only reads. Asking for the next snapshot changes nothing
/// and is allowed in every clock mode.
Outcome AxesCall::check_service(const AxisSnapshot& axis) {
  if (is_fault(axis.state())) return {};
  const Target& target = part_of(axis.id).target;
  Outcome answer = core_->exchange.request(target, ask::next_snapshot(0), "question").outcome();
  if (answer.kind() == OutcomeKind::lost) return answer;
  return answer.code() == wire::number(msg::Reason::shutting_down)
             ? Outcome::lost(name_of(target) +
                             " is shutting down: its service brakes the axes, then exits")
             : Outcome();
}

Outcome AxesCall::stop_if_lost(Outcome outcome) {
  return outcome.kind() == OutcomeKind::lost ? stop_others(std::move(outcome)) : outcome;
}

/// A session that loses an axis gets another epoch on that bench. It learns the new one from the
/// answer to a request; until then the bench refuses every frame, also to the remaining axes.
Outcome AxesCall::renew_control(const Round& round) {
  for (const BenchPart& part : axes_.parts()) {
    const bool has_lost = std::ranges::any_of(part.bench->places, [this](std::size_t place) {
      return is_taken(place);
    });
    if (!has_lost || part.is_lost()) continue;
    std::vector<std::uint16_t> left;
    for (const Round::Entry& entry : round.entries) {
      const AxisId& id = axes_.layout().axes[entry.place];
      if (id.bench == part.bench->number) left.push_back(id.axis);
    }
    if (left.empty()) continue;
    if (Outcome renewed = core_->control.acquire(part.target, left); !renewed) return renewed;
  }
  return {};
}

Outcome AxesCall::send_stop(Outcome cause, Answers& stop) {
  Round round = round_of(kQuickStop, [this](const AxisSnapshot& axis) {
    return is_enabled(axis) && axes_.is_present(axis);
  });
  std::erase_if(round.entries, [this](const Round::Entry& entry) {
    return is_taken(entry.place) || is_superseded_[entry.place] ||
           find_end(entry.place).has_value();
  });
  if (!round.entries.empty()) stop.outcome = renew_control(round);
  // Immediately, because a common tick would be later and a lost bench could not meet it.
  if (stop.outcome && !round.entries.empty()) stop = exchange({&round, 1}, Timing::at_once);
  // A service that is shutting down brakes its axes itself.
  if (stop.outcome || stop.outcome.code() == wire::number(msg::Reason::shutting_down)) return cause;
  return Outcome::failed(cause.message() +
                         ", and the others did not stop: " + stop.outcome.message());
}

Outcome AxesCall::stop_others(Outcome cause) {
  Answers stop;
  cause = send_stop(std::move(cause), stop);
  if (!stop.outcome || stop.tick == 0) return cause;
  set_timeout(kStopTime);
  note_in_force(stop.tick);
  const Outcome rested = await("standstill", stop.tick, [this](const AxisSnapshot& axis) {
    const bool stops = axis.state() == PowerState::quick_stop_active ||
                       axis.state() == PowerState::fault_reaction_active;
    const bool rests = target_reached(axis) && axis.status.velocity_demand_value == 0;
    return !axes_.is_present(axis) || !stops || rests;
  });
  if (rested) return cause;
  return Outcome::failed(cause.message() + ", and the others did not stop: " + rested.message());
}

}  // namespace vdrive::client
