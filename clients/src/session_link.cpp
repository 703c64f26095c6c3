// SPDX-License-Identifier: Apache-2.0
// The link to a bench. The network process of a service may restart: then a new participant sends
// for the same run, and messages in transit are lost. A service carries each message out once,
// however often it arrives, so this session sends every unanswered message again.
#include "session_core.hpp"

#include <algorithm>
#include <vector>

namespace vdrive::client {
namespace {

using Clock = Directory::Clock;
using std::chrono::milliseconds;

// What is not answered within this, while the bench is heard, is sent again.
constexpr milliseconds kRepeatAfter{1'000};

// Between two looks at which participant speaks for the bench.
constexpr milliseconds kLookAtSource{20};

// A queue that is full has room again when its readers follow, or when one that is gone is dropped.
constexpr milliseconds kFullQueue{2'500};

}  // namespace

SessionCore::Link& SessionCore::link_of(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  return links_[key];
}

/// Both ends of all four queues: what is written before that never arrives.
bool SessionCore::is_matched(const wire::Source& source, milliseconds patience) {
  return request_publication_->wait_for_match(source, patience) &&
         command_publication_->wait_for_match(source, patience) &&
         reply_subscription_.wait_for_match(source, patience) &&
         command_reply_subscription_.wait_for_match(source, patience);
}

Outcome SessionCore::await_match(const Target& target) {
  Link& link = link_of(target.key);
  const std::scoped_lock writing(link.mutex);
  if (match_until(link, target.key, Clock::now() + kMatch)) return {};
  return Outcome::lost(
      name_of(target) +
      " was found, but it cannot receive requests: DDS has not matched its reader");
}

/// Before anything is written, with the link's mutex: after a change of the participant first sends
/// again what was not answered. @return whether the way is open.
bool SessionCore::mend(Link& link, const BenchKey& key, milliseconds patience) {
  Lock lock(mutex_);
  const auto source = directory_.source_of(key);
  if (!source || link.source == *source) return true;
  lock.unlock();
  if (!is_matched(*source, patience) || !repeat(key, Clock::time_point::max())) return false;
  lock.lock();
  link.source = *source;
  return true;
}

bool SessionCore::match_until(Link& link, const BenchKey& key, Clock::time_point deadline) {
  while (!mend(link, key, kLookAtSource)) {
    if (Clock::now() >= deadline) return false;
  }
  return true;
}

/// Sends again, in order and with their numbers, what was last sent before that time and is not
/// answered. @return false when a queue is full.
bool SessionCore::repeat(const BenchKey& key, Clock::time_point sent_before) {
  const auto now = Clock::now();
  std::vector<msg::CommandFrame> frames;
  std::vector<msg::Request> requests;
  {
    const std::scoped_lock lock(mutex_);
    for (auto& [name, command] : commands_) {
      if (name.first != key || command.reply || command.sent >= sent_before) continue;
      frames.push_back(command.frame);
      command.sent = now;
    }
    for (auto& [number, request] : requests_) {
      if (request.key != key || request.reply || request.sent >= sent_before) continue;
      requests.push_back(request.request);
      request.sent = now;
    }
  }
  // A step names the last frame before it, and waits for it: frames first.
  return std::ranges::all_of(frames,
                             [this](const msg::CommandFrame& frame) {
                               return command_publication_->write(frame);
                             }) &&
         std::ranges::all_of(requests, [this](const msg::Request& request) {
           return request_publication_->write(request);
         });
}

/// @return whether another participant speaks for the bench than was written to. With the mutex.
bool SessionCore::is_broken(const BenchKey& key) const {
  const auto link = links_.find(key);
  if (link == links_.end() || link->second.source == wire::Source{}) return false;
  const auto source = directory_.source_of(key);
  return source && *source != link->second.source;
}

/// @return whether something was not answered for long by a bench that is heard. With the mutex.
bool SessionCore::is_overdue(const BenchKey& key, Clock::time_point now) const {
  const auto is_late = [&](const auto& awaited) {
    return !awaited.reply && now - awaited.sent >= kRepeatAfter;
  };
  const bool any = std::ranges::any_of(requests_,
                                       [&](const auto& item) {
                                         return item.second.key == key && is_late(item.second);
                                       }) ||
                   std::ranges::any_of(commands_, [&](const auto& item) {
                     return item.first.first == key && is_late(item.second);
                   });
  return any && directory_.is_alive(key, kPresence, now);
}

/// For who waits for an answer. Where somebody else writes just now it is done by them.
void SessionCore::repair(const BenchKey& key) {
  if (!may_command()) return;
  Link& link = link_of(key);
  const std::unique_lock writing(link.mutex, std::try_to_lock);
  if (!writing || !mend(link, key, milliseconds(0))) return;
  (void)repeat(key, Clock::now() - kRepeatAfter);
}

/// @return false when the queue stays full, or the bench falls silent meanwhile.
template <typename Message>
bool SessionCore::write_patiently(wire::Publication<Message>& publication, const BenchKey& key,
                                  const Message& message) {
  const auto deadline = Clock::now() + kFullQueue;
  while (!publication.write(message)) {
    const auto now = Clock::now();
    const std::scoped_lock lock(mutex_);
    if (now >= deadline || !directory_.is_alive(key, options_.silence, now)) return false;
  }
  return true;
}

template bool SessionCore::write_patiently(wire::Publication<msg::Request>& publication,
                                           const BenchKey& key, const msg::Request& message);
template bool SessionCore::write_patiently(wire::Publication<msg::CommandFrame>& publication,
                                           const BenchKey& key, const msg::CommandFrame& message);

bool SessionCore::repair_if_needed(Lock& lock, const BenchKey& key,
                                   Directory::Clock::time_point now) {
  const bool was_broken = is_broken(key);
  if (was_broken || is_overdue(key, now)) {
    lock.unlock();
    repair(key);
    lock.lock();
  }
  return was_broken;
}

std::optional<Outcome> SessionCore::end_of_wait(const Target& target, const Patience& patience,
                                                Directory::Clock::time_point begin,
                                                Directory::Clock::time_point now) {
  if (interrupted_ && patience.may_interrupt) return Outcome::failed("interrupted");
  if (!directory_.is_alive(target.key, options_.silence, now)) return gone(target);
  if (patience.needs_drive_time && directory_.is_paused(target.key, begin)) {
    return Outcome::failed(paused_text(target));
  }
  if (now >= begin + patience.timeout) {
    return Outcome::timed_out(name_of(target) + " did not answer");
  }
  return std::nullopt;
}

}  // namespace vdrive::client
