// SPDX-License-Identifier: Apache-2.0
#include "group_talk.hpp"

#include "command_words.hpp"
#include "conversation.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// Wall time without a sample after which a stream is looked at again: a paused bench is waited for.
constexpr milliseconds kPatience{500};

// A frame for a tick that several benches share is sent this far ahead; a bench that is busier
// refuses it as too late, and the next attempt goes further.
constexpr milliseconds kFirstMargin{20};
constexpr int kMarginGrowth = 4;
constexpr int kAttempts = 4;

// Benches whose clocks differ by more do not act on common ticks.
constexpr milliseconds kSynchronised{100};

// Axes that a message names; the others are counted.
constexpr std::size_t kMostNamed = 4;

// Longer than any stop by the steepest ramps that the defaults allow.
constexpr std::chrono::seconds kStopTime{5};

}  // namespace

Outcome not_in_this_state(std::string message) {
  return Outcome::refused(wire_code(AbortCode::refused_in_present_device_state),
                          std::move(message));
}

GroupTalk::GroupTalk(std::shared_ptr<SessionCore> core, const GroupLayout& layout,
                     std::function<void(std::uint64_t, std::span<const AxisSnapshot>)> observer)
    : core_(std::move(core)),
      layout_(layout),
      observer_(std::move(observer)),
      now_(layout.axes.size()) {}

// ---- looking ---------------------------------------------------------------------------------

Outcome GroupTalk::connect() {
  for (const GroupLayout::Bench& bench : layout_.benches) {
    auto target = core_->connection.connect(bench.number);
    if (!target) return target.outcome();
    Line& line = lines_.emplace_back();
    line.bench = &bench;
    line.target = *target;
    if (!line.target.steps()) line.feed = core_->stream.open_feed(line.target, bench.axes);
  }
  return compare_clocks();
}

Outcome GroupTalk::compare_clocks() const {
  const Target& first = lines_.front().target;
  for (const Line& line : lines_) {
    const Target& other = line.target;
    const std::string pair = name_of(first) + " and " + name_of(other);
    if (other.clock_mode != first.clock_mode) {
      return Outcome::refused(msg::REASON_WRONG_CLOCK_MODE,
                              pair + " have different clock modes and cannot form a group");
    }
    if (other.period != first.period) {
      return Outcome::refused(msg::REASON_WRONG_CLOCK_MODE,
                              pair + " have different periods and cannot form a group");
    }
    const bool shared = other.steps() || (other.clock_mode == ClockMode::realtime &&
                                          other.rate == 1.0 && first.rate == 1.0);
    if (lines_.size() > 1 && !shared) {
      return Outcome::refused(
          msg::REASON_WRONG_CLOCK_MODE,
          pair + " do not share a clock: a group needs lock-step, or real time at rate 1");
    }
  }
  return {};
}

Outcome GroupTalk::listen(std::chrono::nanoseconds timeout) {
  if (Outcome connected = connect(); !connected) return connected;
  if (Outcome seen = steps() ? advance(0) : look_at_streams(); !seen) return seen;
  set_timeout(timeout);
  return {};
}

/// The first sample of each stream, then the first tick that all of them show.
Outcome GroupTalk::look_at_streams() {
  for (Line& line : lines_) {
    Outcome seen = line.target.is_paused
                       ? note(line, core_->observer.observe(line.target, line.bench->axes))
                       : next(line);
    if (!seen) return seen;
  }
  if (Outcome shared = await_common_ticks(); !shared) return shared;
  if (Outcome aligned = align(); !aligned) return aligned;
  publish();
  return {};
}

/// A bench that is only heard late, as after a link was down, catches up; one whose clock differs
/// never does.
Outcome GroupTalk::await_common_ticks() {
  const std::uint64_t apart = ticks_of(kSynchronised, period());
  const auto behind = [](const Line& line) {
    return line.seen.tick;
  };
  const auto give_up = std::chrono::steady_clock::now() + core_->discovery.silence();
  while (true) {
    const auto [least, most] = std::ranges::minmax_element(lines_, {}, behind);
    if (most->seen.tick - least->seen.tick <= apart) return {};
    if (std::chrono::steady_clock::now() > give_up) {
      return Outcome::refused(
          msg::REASON_WRONG_CLOCK_MODE,
          name_of(least->target) + " and " + name_of(most->target) +
              " have different tick numbers: their clocks are not synchronised");
    }
    if (Outcome seen = next(*least); !seen) return seen;
    // Who waits for one bench must not fall behind on the others.
    for (Line& line : lines_) {
      if (Outcome seen = catch_up(line); !seen) return seen;
    }
  }
}

/// Takes what has arrived, without waiting.
Outcome GroupTalk::catch_up(Line& line) {
  while (true) {
    auto sample = core_->stream.next(line.target, *line.feed, {milliseconds(0), true});
    if (sample.outcome().kind() == OutcomeKind::timed_out) return {};
    if (Outcome noted = note(line, std::move(sample)); !noted) return noted;
  }
}

void GroupTalk::set_timeout(std::chrono::nanoseconds timeout) {
  deadline_ = tick_ + ticks_of(timeout, period());
}

Outcome GroupTalk::take_control(std::chrono::nanoseconds timeout) {
  if (Outcome heard = listen(timeout); !heard) return heard;
  return acquire();
}

Outcome GroupTalk::acquire() {
  for (Line& line : lines_) {
    const bool ours = std::ranges::all_of(line.seen.axes, [this](const AxisSnapshot& axis) {
      return axis.owner_session == core_->id;
    });
    if (ours && core_->control.holds(line.target, line.bench->axes)) continue;
    if (Outcome taken = core_->control.acquire(line.target, line.bench->axes); !taken) {
      return note_lost(line, std::move(taken));
    }
  }
  return {};
}

Outcome GroupTalk::advance(std::uint64_t ticks) {
  Outcome result;
  for (Line& line : lines_) {
    if (line.is_lost) continue;
    Outcome seen = line.feed ? next(line)
                             : note(line, core_->clocks.step(line.target, ticks, line.bench->axes));
    if (!seen && !line.is_lost) return seen;
    if (!seen && result) result = std::move(seen);
  }
  if (!result) return result;
  if (Outcome aligned = align(); !aligned) return aligned;
  publish();
  return {};
}

Outcome GroupTalk::next(Line& line) {
  while (true) {
    auto sample = core_->stream.next(line.target, *line.feed, {kPatience, true});
    if (stop_.stop_requested()) return Outcome::failed("interrupted");
    if (sample.outcome().kind() == OutcomeKind::timed_out) continue;
    return note(line, std::move(sample));
  }
}

std::string GroupTalk::axes_of(const Line& line) {
  const auto& axes = line.bench->axes;
  std::string text;
  for (std::size_t i = 0; i < std::min(axes.size(), kMostNamed); ++i) {
    text += (i == 0 ? "axis " : ", axis ") + to_string(AxisId{line.bench->number, axes[i]});
  }
  if (axes.size() > kMostNamed)
    text += " and " + std::to_string(axes.size() - kMostNamed) + " more";
  return text;
}

/// @return `outcome`; when it says that the bench is lost, with the axes that are lost with it.
Outcome GroupTalk::note_lost(Line& line, Outcome outcome) {
  if (outcome.kind() != OutcomeKind::lost) return outcome;
  line.is_lost = true;
  return Outcome::lost(axes_of(line) + ": " + outcome.message());
}

Outcome GroupTalk::note(Line& line, Result<Observation> sample) {
  if (!sample) return note_lost(line, sample.outcome());
  line.seen = std::move(*sample);
  return {};
}

/// Samples of a stream may be missing: goes on until all benches show the same tick.
Outcome GroupTalk::align() {
  std::uint64_t newest = 0;
  bool moved = !steps();
  while (moved) {
    moved = false;
    for (const Line& line : lines_) newest = std::max(newest, line.seen.tick);
    for (Line& line : lines_) {
      while (!line.is_lost && line.seen.tick < newest) {
        if (Outcome seen = next(line); !seen) return seen;
        moved = true;
      }
    }
  }
  return {};
}

void GroupTalk::publish() {
  for (const Line& line : lines_) {
    if (line.is_lost) continue;
    for (std::size_t i = 0; i < line.bench->places.size(); ++i) {
      AxisSnapshot& axis = now_[line.bench->places[i]];
      axis = line.seen.axes[i];
      axis.tick = line.seen.tick;
    }
  }
  const auto heard = std::ranges::find(lines_, false, &Line::is_lost);
  tick_ = heard == lines_.end() ? tick_ : heard->seen.tick;
  if (observer_) observer_(tick_, now_);
}

Outcome GroupTalk::timed_out(std::string_view awaited, std::span<const std::size_t> late) const {
  std::string message = "timed out while waiting for " + std::string(awaited);
  for (std::size_t i = 0; i < std::min(late.size(), kMostNamed); ++i) {
    const AxisSnapshot& axis = now_[late[i]];
    message +=
        (i == 0 ? " of axis " : "; axis ") + to_string(axis.id) + ", which " + what_it_shows(axis);
  }
  if (late.size() > kMostNamed) {
    message += "; and " + std::to_string(late.size() - kMostNamed) + " more";
  }
  return Outcome::timed_out(std::move(message));
}

std::vector<msg::Request> GroupTalk::read_requests(const Line& line,
                                                   std::span<const ObjectAddress> objects) {
  const std::size_t axes_a_request = msg::MAX_OBJECTS_PER_REQUEST / objects.size();
  std::vector<msg::Request> requests;
  for (std::size_t i = 0; i < line.bench->axes.size(); ++i) {
    if (i % axes_a_request == 0) requests.emplace_back().kind(msg::REQUEST_READ);
    for (const ObjectAddress& object : objects) {
      auto& access = requests.back().objects().emplace_back();
      access.axis(line.bench->axes[i]);
      access.index(object.index);
      access.subindex(object.subindex);
    }
  }
  return requests;
}

Result<std::vector<std::vector<std::int64_t>>> GroupTalk::read(
    std::span<const ObjectAddress> objects) {
  std::vector<std::vector<std::int64_t>> values(now_.size());
  for (Line& line : lines_) {
    const auto replies = core_->requests.exchange_all(line.target, read_requests(line, objects),
                                                      "read of axes of " + name_of(line.target));
    if (!replies) return note_lost(line, replies.outcome());
    std::vector<msg::ObjectResult> results;
    for (const msg::Reply& reply : *replies) {
      results.insert(results.end(), reply.objects().begin(), reply.objects().end());
    }
    if (results.size() != line.bench->axes.size() * objects.size()) {
      return Outcome::failed(name_of(line.target) + " answered the read only in part");
    }
    for (std::size_t i = 0; i < results.size(); ++i) {
      if (results[i].abort_code() != 0) {
        return Outcome::refused(results[i].abort_code(),
                                "read of " + name_of(line.target, results[i].axis()) + " refused");
      }
      values[line.bench->places[i / objects.size()]].push_back(results[i].value());
    }
  }
  return values;
}

// ---- saying ----------------------------------------------------------------------------------

msg::AxisCommand GroupTalk::command_to(std::size_t place) const {
  msg::AxisCommand command;
  command.axis(layout_.axes[place].axis);
  return command;
}

Result<std::uint64_t> GroupTalk::newest_tick() {
  std::uint64_t newest = tick_;
  for (const Line& line : lines_) {
    const auto present = core_->observer.present_tick(line.target);
    if (!present) return present.outcome();
    newest = std::max(newest, *present);
  }
  return newest;
}

Told GroupTalk::tell(std::span<const Round> rounds, Timing timing) {
  if (timing == Timing::at_once || lines_.size() == 1 || steps()) return tell_at(rounds, 0);
  milliseconds margin = kFirstMargin;
  for (int attempt = 1;; ++attempt) {
    const auto newest = newest_tick();
    if (!newest) return {newest.outcome(), 0, {}};
    Told told = tell_at(rounds, *newest + ticks_of(margin, period()));
    const bool untouched = told.outcome.code() == msg::REASON_TOO_LATE && told.tick == 0;
    if (!untouched || attempt == kAttempts) return told;
    margin *= kMarginGrowth;
  }
}

Told GroupTalk::tell_at(std::span<const Round> rounds, std::uint64_t apply_at) {
  std::vector<SentFrames> sent;
  Outcome outcome;
  for (const Round& round : rounds) {
    if (outcome) outcome = send(round, apply_at, sent);
  }
  if (outcome && apply_at != 0) {
    const auto accepted = core_->commands.await_answers(sent);
    if (!accepted || !*accepted) cancel_pending();
  }
  return collect(sent, std::move(outcome));
}

Outcome GroupTalk::send(const Round& round, std::uint64_t apply_at, std::vector<SentFrames>& sent) {
  sent.resize(lines_.size());
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const Line& line = lines_[i];
    sent[i].target = line.target;
    FrameContent frame{.commands = {}, .apply_at_tick = apply_at, .flags = round.flags};
    for (const Round::Word& word : round.words) {
      if (layout_.axes[word.place].bench == line.bench->number) {
        frame.commands.push_back(word.command);
      }
    }
    if (frame.commands.empty() || line.is_lost) continue;
    if (Outcome outcome = core_->commands.send(sent[i], {&frame, 1}); !outcome) {
      return outcome;
    }
  }
  return {};
}

/// Takes back the frames that still wait on the other benches when one has refused.
void GroupTalk::cancel_pending() {
  const FrameContent cancel{.commands = {}, .flags = msg::FRAME_CANCEL_PENDING};
  for (const Line& line : lines_) {
    SentFrames sent{.target = line.target, .sequences = {}};
    Outcome outcome = core_->commands.send(sent, {&cancel, 1});
    (void)core_->commands.collect(sent, std::move(outcome));  // the frames' answers tell
  }
}

Told GroupTalk::collect(std::span<const SentFrames> sent, Outcome outcome) {
  Told told{std::move(outcome), 0, {}};
  const bool wait = static_cast<bool>(told.outcome);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (sent[i].sequences.empty()) continue;
    auto applied = core_->commands.collect(sent[i], wait ? Outcome() : told.outcome);
    applied.outcome = note_lost(lines_[i], std::move(applied.outcome));
    // What was cancelled was cancelled because of another refusal, which says more.
    if (!applied.outcome && (told.outcome || told.outcome.code() == msg::REASON_CANCELLED)) {
      told.outcome = applied.outcome;
    }
    told.tick = std::max(told.tick, applied.tick);
    note_ignored(lines_[i], applied.ignored_set_points, told);
  }
  return told;
}

void GroupTalk::note_ignored(const Line& line, std::span<const std::uint16_t> axes, Told& told) {
  for (std::size_t i = 0; i < line.bench->axes.size(); ++i) {
    if (std::ranges::find(axes, line.bench->axes[i]) != axes.end()) {
      told.ignored.push_back(line.bench->places[i]);
    }
  }
}

// ---- guarding --------------------------------------------------------------------------------

Outcome GroupTalk::check(std::string_view awaited, std::uint64_t from) {
  if (tick_ < from) return {};
  for (const AxisSnapshot& axis : now_) {
    if (is_enabled(axis)) continue;
    return stop_others(Outcome::failed("axis " + to_string(axis.id) + ": waited for " +
                                       std::string(awaited) + ", " + what_it_shows(axis)));
  }
  return {};
}

Outcome GroupTalk::stop_if_lost(Outcome outcome) {
  return outcome.kind() == OutcomeKind::lost ? stop_others(std::move(outcome)) : outcome;
}

bool GroupTalk::is_heard(const AxisSnapshot& axis) const {
  return std::ranges::any_of(lines_, [&axis](const Line& line) {
    return line.bench->number == axis.id.bench && !line.is_lost;
  });
}

Outcome GroupTalk::say_stop(Outcome cause, Told& stop) {
  const Round round = round_of(kQuickStop, [this](const AxisSnapshot& axis) {
    return is_enabled(axis) && is_heard(axis);
  });
  if (!round.words.empty()) stop = tell({&round, 1}, Timing::at_once);
  if (stop.outcome) return cause;
  return Outcome::failed(cause.message() +
                         ", and the others did not stop: " + stop.outcome.message());
}

Outcome GroupTalk::stop_others(Outcome cause) {
  Told stop;
  cause = say_stop(std::move(cause), stop);
  if (!stop.outcome || stop.tick == 0) return cause;
  set_timeout(kStopTime);
  const Outcome rested = look_until("rest", stop.tick, [&](std::size_t place) {
    const AxisSnapshot& axis = now_[place];
    const bool stops = axis.state() == PowerState::quick_stop_active ||
                       axis.state() == PowerState::fault_reaction_active;
    const bool rests = target_reached(axis) && axis.status.velocity_demand_value == 0;
    return !is_heard(axis) || !stops || rests;
  });
  if (rested) return cause;
  return Outcome::failed(cause.message() + ", and the others did not stop: " + rested.message());
}

Outcome GroupTalk::await_quick_stops() {
  using namespace literals;
  const bool none = std::ranges::none_of(now_, [](const AxisSnapshot& axis) {
    return axis.state() == PowerState::quick_stop_active;
  });
  if (none) return {};
  const std::array option{vdrive::describe("quick_stop_option_code"_object).address};
  const auto options = read(option);
  if (!options) return options.outcome();
  return look_until("the end of the quick stop", tick_, [&](std::size_t place) {
    return quick_stop_ended(now_[place], (*options)[place].front());
  });
}

}  // namespace vdrive::client
