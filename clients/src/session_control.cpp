// SPDX-License-Identifier: Apache-2.0
// Requests, control of axes, commands.
#include "session_core.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A service whose samples arrive answers within this time, or it never answers.
constexpr SessionCore::Patience kAnswer{milliseconds(10'000), false};

// A frame for a later tick is answered in that tick.
constexpr SessionCore::Patience kAnswerInItsTick{std::chrono::hours(24), true, true};

constexpr milliseconds kReleaseAnswer{500};
constexpr milliseconds kKeepAlivePeriod{25};

// While a bench connects anew: its watchdog runs.
constexpr milliseconds kKeepAliveRetry{5};

}  // namespace

Outcome refusal_of(const Target& target, const msg::Reply& reply, std::string_view what) {
  std::string message(what);
  message += " refused";
  if (reply.owner_session() != 0) {
    message +=
        ", " +
        (reply.refused_axis() == 0 ? std::string("it") : name_of(target, reply.refused_axis())) +
        " is held by session " + session_text(reply.owner_session());
  } else if (reply.refused_axis() != 0) {
    message += " because of " + name_of(target, reply.refused_axis());
  }
  return Outcome::refused(reply.reason(), std::move(message));
}

namespace {

/// @param tick that the refused frame was meant for, 0 = any
Outcome refusal_of(const Target& target, const msg::Refusal& refusal, std::uint64_t tick,
                   std::uint64_t next_tick) {
  if (refusal.axis() == 0) {
    std::string message = name_of(target) + " refused the command frame";
    if (refusal.reason() == msg::REASON_TOO_LATE && tick != 0 && tick < next_tick) {
      message += ", late by " + std::to_string(next_tick - tick) + " ticks";
    }
    return Outcome::refused(refusal.reason(), std::move(message));
  }
  std::string message = name_of(target, refusal.axis()) + " refused ";
  if (refusal.index() == 0) {
    message += "the command";
  } else {
    const auto row = find_object(ObjectAddress{refusal.index(), refusal.subindex()});
    message += row ? std::string(describe(*row).variable_name) : hex(refusal.index(), 4);
  }
  return Outcome::refused(refusal.reason(), std::move(message));
}

}  // namespace

Result<std::uint64_t> SessionCore::send_request(const Target& target, msg::Request request,
                                                milliseconds patience) {
  if (!may_command()) return not_permitted(target);
  Link& link = link_of(target.key);
  const std::scoped_lock writing(link.mutex);
  if (!match_until(link, target.key, Directory::Clock::now() + patience)) {
    return Outcome::lost(
        name_of(target) +
        " was found, but it cannot receive requests: DDS has not matched its reader");
  }
  Lock lock(mutex_);
  const std::uint64_t number = ++last_request_;
  request.client(id_);
  request.request_id(number);
  request.bench(target.key.number);
  request.incarnation(target.key.incarnation);
  request.session(id_);
  const auto entry = requests_.emplace(number, AwaitedRequest{.key = target.key,
                                                              .request = std::move(request),
                                                              .sent = Directory::Clock::now(),
                                                              .reply = std::nullopt});
  lock.unlock();
  // No other thread removes the entry; the thread that repeats the request only reads it.
  if (write_patiently(*request_publication_, target.key, entry.first->second.request))
    return number;
  lock.lock();
  requests_.erase(number);
  return Outcome::lost(name_of(target) + " accepts no more requests");
}

Result<msg::Reply> SessionCore::await_reply(const Target& target, std::uint64_t number,
                                            Patience patience) {
  Lock lock(mutex_);
  Outcome outcome = wait(lock, target, patience, [&] {
    return requests_.at(number).reply.has_value();
  });
  std::optional<msg::Reply> reply = std::move(requests_.at(number).reply);
  requests_.erase(number);
  if (!outcome) return outcome;
  return std::move(*reply);
}

Result<std::vector<msg::Reply>> SessionCore::requests(const Target& target,
                                                      std::vector<msg::Request> requests,
                                                      std::string_view what) {
  Outcome outcome;
  std::vector<std::uint64_t> numbers;
  for (msg::Request& request : requests) {
    const auto number = send_request(target, std::move(request));
    if (!number) {
      outcome = number.outcome();
      break;
    }
    numbers.push_back(*number);
  }
  std::vector<msg::Reply> replies;
  for (const std::uint64_t number : numbers) {
    if (!outcome) {
      const std::scoped_lock lock(mutex_);
      requests_.erase(number);
      continue;
    }
    auto reply = await_reply(target, number, kAnswer);
    if (!reply) {
      outcome = reply.outcome();
    } else if (reply->reason() != msg::REASON_NONE) {
      outcome = refusal_of(target, *reply, what);
    } else {
      replies.push_back(std::move(*reply));
    }
  }
  if (!outcome) return outcome;
  return replies;
}

Result<msg::Reply> SessionCore::request(const Target& target, msg::Request request,
                                        std::string_view what) {
  const auto number = send_request(target, std::move(request));
  if (!number) return number.outcome();
  auto reply = await_reply(target, *number, kAnswer);
  if (!reply) return reply;
  if (reply->reason() != msg::REASON_NONE) return refusal_of(target, *reply, what);
  return reply;
}

Result<msg::Reply> SessionCore::request_control(const Target& target, msg::Request request,
                                                std::string_view what) {
  const std::scoped_lock sending(send_mutex_of(target.key.number));
  return this->request(target, std::move(request), what);
}

Result<msg::Reply> SessionCore::request_snapshot(std::uint32_t bench, std::uint32_t kind,
                                                 std::uint64_t snapshot) {
  const auto target = connect(bench);
  if (!target) return target.outcome();
  msg::Request request;
  request.kind(kind);
  request.snapshot(snapshot);
  const bool names_one = kind != msg::REQUEST_TAKE_SNAPSHOT;
  return request_control(
      *target, std::move(request),
      "snapshot " + (names_one ? std::to_string(snapshot) + " " : "") + "of " + name_of(*target));
}

std::mutex& SessionCore::send_mutex_of(std::uint32_t bench) {
  const std::scoped_lock lock(mutex_);
  return send_mutexes_[bench];  // stays where it is when others are added
}

SessionCore::Holding& SessionCore::holding(const BenchKey& key) {
  Holding& holding = holdings_[key.number];
  if (holding.key != key) {
    holding = {};
    holding.key = key;
  }
  return holding;
}

void SessionCore::note_acquired(const Target& target, std::span<const std::uint16_t> axes,
                                const msg::Reply& reply) {
  if (reply.epoch() == 0) return;
  {
    const std::scoped_lock lock(mutex_);
    Holding& held = holding(target.key);
    if (held.epoch != reply.epoch()) held.epoch_since = held.sequence + 1;
    held.epoch = reply.epoch();
    held.lives_by_wall_clock = !target.steps();
    held.axes.insert(axes.begin(), axes.end());
  }
  start_keep_alive();
}

bool SessionCore::holds(const Target& target, std::span<const std::uint16_t> axes) {
  const std::scoped_lock lock(mutex_);
  const std::set<std::uint16_t>& held = holding(target.key).axes;
  return std::ranges::all_of(axes, [&held](std::uint16_t axis) {
    return held.contains(axis);
  });
}

Outcome SessionCore::acquire(const Target& target, std::uint16_t axis, bool shows_us) {
  if (shows_us && holds(target, {&axis, 1})) return {};
  return acquire(target, {&axis, 1});
}

Outcome SessionCore::acquire(const Target& target, std::span<const std::uint16_t> axes) {
  msg::Request request;
  request.kind(msg::REQUEST_ACQUIRE);
  request.axes().assign(axes.begin(), axes.end());
  const std::string what =
      "control of " + (axes.size() == 1 ? name_of(target, axes.front()) : name_of(target));
  const auto reply = request_control(target, std::move(request), what);
  if (!reply) return reply.outcome();
  note_acquired(target, axes, *reply);
  return {};
}

Result<msg::Reply> SessionCore::write(const Target& target, msg::Request request,
                                      std::string_view what) {
  const bool commands = std::ranges::any_of(request.objects(), [](const msg::ObjectAccess& access) {
    return has_role({access.index(), access.subindex()}, Role::command);
  });
  const std::uint16_t axis = request.objects().front().axis();
  // A store waits for a disk: it must not hold up the keep-alives.
  auto reply = commands ? request_control(target, std::move(request), what)
                        : this->request(target, std::move(request), what);
  if (commands && reply && reply->objects().front().abort_code() == 0) {
    note_acquired(target, {&axis, 1}, *reply);
  }
  return reply;
}

Outcome SessionCore::release() {
  std::map<std::uint32_t, Holding> holdings;
  {
    const std::scoped_lock lock(mutex_);
    holdings = holdings_;
    for (auto& [number, holding] : holdings_) holding.axes.clear();
  }
  Outcome result;
  for (const auto& [number, holding] : holdings) {
    if (holding.axes.empty()) continue;
    // Also after an interrupt, and to a service that may be gone: so not by request().
    const std::scoped_lock sending(send_mutex_of(number));
    const Target target{.key = holding.key};
    msg::Request request;
    request.kind(msg::REQUEST_RELEASE);
    const auto sent = send_request(target, std::move(request), kReleaseAnswer);
    if (!sent || !await_reply(target, *sent, {kReleaseAnswer, false})) {
      result = Outcome::lost(name_of(target) + " did not answer");
    }
  }
  return result;
}

void SessionCore::interrupt() noexcept {
  const std::scoped_lock lock(mutex_);
  interrupted_ = true;
  changed_.notify_all();
}

// ---- commands -----------------------------------------------------------------------------

msg::CommandFrame SessionCore::next_frame(Holding& held) const {
  msg::CommandFrame frame;
  frame.bench(held.key.number);
  frame.incarnation(held.key.incarnation);
  frame.session(id_);
  frame.epoch(held.epoch);
  frame.sequence_number(++held.sequence);
  return frame;
}

Outcome SessionCore::send(const Target& target, std::span<const FrameContent> frames,
                          std::vector<std::uint64_t>& sequences) {
  if (!may_command()) return not_permitted(target);
  const std::scoped_lock sending(send_mutex_of(target.key.number));
  for (const FrameContent& content : frames) {
    if (Outcome sent = send(target, content, sequences); !sent) return sent;
  }
  return {};
}

Outcome SessionCore::send(const Target& target, const FrameContent& content,
                          std::vector<std::uint64_t>& sequences) {
  Link& link = link_of(target.key);
  const std::scoped_lock writing(link.mutex);
  if (!match_until(link, target.key, Directory::Clock::now() + kMatch)) {
    return Outcome::lost(
        name_of(target) +
        " was found, but it cannot receive commands: DDS has not matched its reader");
  }
  Lock lock(mutex_);
  msg::CommandFrame frame = next_frame(holding(target.key));
  const std::uint64_t sequence = frame.sequence_number();
  frame.flags(content.flags | msg::FRAME_WANT_REPLY);
  frame.apply_at_tick(content.apply_at_tick);
  frame.valid_until_tick(content.apply_at_tick);
  frame.axes() = content.commands;
  const auto entry = commands_.emplace(
      PendingCommand{target.key, sequence},
      AwaitedCommand{
          .frame = std::move(frame), .sent = Directory::Clock::now(), .reply = std::nullopt});
  lock.unlock();
  sequences.push_back(sequence);
  if (write_patiently(*command_publication_, target.key, entry.first->second.frame)) return {};
  return Outcome::lost(name_of(target) + " accepts no more commands");
}

Applied SessionCore::collect(const Target& target, std::span<const std::uint64_t> sequences,
                             Outcome outcome) {
  Applied applied;
  Lock lock(mutex_);
  for (const std::uint64_t sequence : sequences) {
    const auto entry = commands_.find({target.key, sequence});
    const AwaitedCommand& awaited = entry->second;
    const std::uint64_t apply_at = awaited.frame.apply_at_tick();
    if (outcome) {
      outcome = wait(lock, target, apply_at == 0 ? kAnswer : kAnswerInItsTick, [&] {
        return awaited.reply.has_value();
      });
    }
    if (outcome && !awaited.reply->refusals().empty()) {
      if (applied.outcome) {
        applied.outcome =
            refusal_of(target, awaited.reply->refusals().front(), apply_at, awaited.reply->tick());
      }
    } else if (outcome) {
      applied.tick = std::max(applied.tick, awaited.reply->tick());
      const auto& ignored = awaited.reply->ignored_set_points();
      applied.ignored_set_points.insert(applied.ignored_set_points.end(), ignored.begin(),
                                        ignored.end());
    }
    commands_.erase(entry);
  }
  if (!outcome) applied.outcome = std::move(outcome);
  return applied;
}

bool SessionCore::is_answered(const SentFrames& sent) const {
  return std::ranges::all_of(sent.sequences, [&](std::uint64_t sequence) {
    return commands_.at({sent.target.key, sequence}).reply.has_value();
  });
}

bool SessionCore::is_refused(const SentFrames& sent) const {
  return std::ranges::any_of(sent.sequences, [&](std::uint64_t sequence) {
    const auto& reply = commands_.at({sent.target.key, sequence}).reply;
    return reply && !reply->refusals().empty();
  });
}

Result<bool> SessionCore::await_answers(std::span<const SentFrames> sent) {
  Lock lock(mutex_);
  const auto any_refused = [&] {
    return std::ranges::any_of(sent, [&](const SentFrames& frames) {
      return is_refused(frames);
    });
  };
  for (const SentFrames& frames : sent) {
    Outcome outcome = wait(lock, frames.target, kAnswer, [&] {
      return is_answered(frames) || any_refused();
    });
    if (!outcome) return outcome;
  }
  return !any_refused();
}

Result<Applied> SessionCore::command(const Target& target,
                                     std::span<const msg::AxisCommand> commands) {
  std::vector<FrameContent> frames;
  for (const msg::AxisCommand& command : commands) frames.push_back({.commands = {command}});
  std::vector<std::uint64_t> sequences;
  Outcome outcome = send(target, frames, sequences);
  if (outcome && target.steps()) outcome = step(target, 1, {}).outcome();
  Applied applied = collect(target, sequences, std::move(outcome));
  if (!applied.outcome) return applied.outcome;
  return applied;
}

// ---- keeping control ----------------------------------------------------------------------

void SessionCore::start_keep_alive() {
  if (options_.keep_alive != KeepAlive::own_thread) return;
  std::call_once(keep_alive_started_, [this] {
    keep_alive_thread_ = std::jthread([this](const std::stop_token& stop) {
      keep_alive(stop);
    });
  });
}

void SessionCore::keep_alive(const std::stop_token& stop) {
  std::condition_variable_any sleep;
  std::mutex sleep_mutex;
  std::unique_lock sleeping(sleep_mutex);
  while (!stop.stop_requested()) {
    std::vector<BenchKey> benches;
    {
      const std::scoped_lock lock(mutex_);
      for (const auto& [number, holding] : holdings_) {
        if (holding.lives_by_wall_clock && !holding.axes.empty()) benches.push_back(holding.key);
      }
    }
    bool are_all_reached = true;
    for (const BenchKey& bench : benches) are_all_reached &= send_keep_alive(bench);
    sleep.wait_for(sleeping, stop, are_all_reached ? kKeepAlivePeriod : kKeepAliveRetry, [] {
      return false;
    });
  }
}

/// @return false when the bench connects anew and is not reached yet.
bool SessionCore::send_keep_alive(const BenchKey& key) {
  // Busy: a frame or a request is on its way, which says the same.
  const std::unique_lock sending(send_mutex_of(key.number), std::try_to_lock);
  if (!sending) return true;
  Link& link = link_of(key);
  const std::unique_lock writing(link.mutex, std::try_to_lock);
  if (!writing) return true;
  if (!mend(link, key, milliseconds(0))) return false;
  Lock lock(mutex_);
  Holding& held = holdings_.at(key.number);
  if (held.key != key) return true;
  const msg::CommandFrame frame = next_frame(held);
  lock.unlock();
  (void)command_publication_->write(frame);  // what is not taken now is said again in 25 ms
  return true;
}

}  // namespace vdrive::client
