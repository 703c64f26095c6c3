// SPDX-License-Identifier: Apache-2.0
#include "exchange/bench_links.hpp"

#include "vdrive/wire/reply.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using Clock = Discovery::Clock;
using std::chrono::milliseconds;

// A message not answered within this time, while samples of the bench arrive, is sent again.
constexpr milliseconds kRepeatAfter{1'000};

// Interval at which a wait for a match checks whether the bench has another participant.
constexpr milliseconds kCheckSource{20};

// Within this time a full queue has room again: its readers have caught up, or a lost reader has
// been dropped.
constexpr milliseconds kFullQueue{2'500};

constexpr const char* kSessionEnded = "the session has ended: nothing was sent";

/// @return null if the permissions of this participant do not include the topic.
template <typename Message>
std::unique_ptr<wire::Publication<Message>> publication_if_permitted(
    wire::Participant& participant) {
  try {
    return std::make_unique<wire::Publication<Message>>(participant);
  } catch (const wire::NotPermitted&) {
    return nullptr;
  }
}

}  // namespace

BenchLinks::BenchLinks(wire::Participant& participant, std::uint64_t session, Discovery& discovery,
                       HeldAxes& held_axes, CommandHistory& history, Wakeup& wakeup,
                       ObserverFailure& failure)
    : session_(session),
      participant_(participant),
      discovery_(discovery),
      held_axes_(held_axes),
      history_(history),
      wakeup_(wakeup),
      failure_(failure),
      request_publication_(publication_if_permitted<msg::Request>(participant)),
      command_publication_(publication_if_permitted<msg::CommandFrame>(participant)),
      reply_reader_(participant.make_reader(wire::Topic<msg::Reply>::kId,
                                            {.take =
                                                 [this](std::span<const std::byte> sample) {
                                                   take_reply(sample);
                                                 },
                                             .deliver =
                                                 [this](const wire::Source& source) {
                                                   if (is_received_) on_reply(source);
                                                 }})),
      command_reply_subscription_(
          participant, [this](const msg::CommandReply& message, const wire::Source& source) {
            on_command_reply(message, source);
          }) {}

// ---- receiving -------------------------------------------------------------------------------

void BenchLinks::take_reply(std::span<const std::byte> sample) {
  if (received_.axes.capacity() == 0) {
    const std::scoped_lock lock(mutex_);
    received_.axes.swap(spare_);
  }
  is_received_ = wire::decode_reply(sample, received_, received_.axes);
}

void BenchLinks::reuse(std::vector<wire::ReceivedStatus> axes) {
  const std::scoped_lock lock(mutex_);
  spare_.swap(axes);
}

void BenchLinks::on_reply(const wire::Source& source) {
  if (received_.client != session_) return;
  discovery_.note_sample({received_.bench, received_.incarnation}, received_.tick, source);
  const std::uint64_t number = received_.request_id;
  if (unanswered_.requests.answer(number, std::move(received_))) wakeup_.notify();
}

void BenchLinks::on_command_reply(const msg::CommandReply& message, const wire::Source& source) {
  if (message.session != session_) return;
  const BenchKey key{message.bench, message.incarnation};
  discovery_.note_sender(key, source);
  // First: the call that receives the answer must find any loss of control that the answer reports.
  held_axes_.note_answer(message);
  history_.note_answer(message);
  if (unanswered_.frames.answer({key, message.sequence_number}, message)) {
    wakeup_.notify();
  } else {
    report_refusals(message);
  }
}

void BenchLinks::watch_refusals(std::function<void(const SetPointRefusal&)> observer) {
  const std::scoped_lock lock(refusal_mutex_);
  refusal_observer_ = std::move(observer);
}

/// @param message the answer to a frame that no call waits for
void BenchLinks::report_refusals(const msg::CommandReply& message) {
  if (message.refusals.empty()) return;
  const std::scoped_lock lock(refusal_mutex_);
  if (!refusal_observer_) return;
  for (const msg::Refusal& refusal : message.refusals) {
    if (refusal.index == 0) continue;  // refers to an entire command or frame
    refusal_observer_({.axis = {.bench = message.bench, .axis = refusal.axis},
                       .object = {.index = refusal.index, .subindex = refusal.subindex},
                       .code = static_cast<AbortCode>(refusal.reason)});
  }
}

// ---- matching --------------------------------------------------------------------------------

Result<Target> BenchLinks::connect(std::uint32_t number) {
  if (is_closed_) return Outcome::failed(kSessionEnded);
  failure_.rethrow();
  const auto bench = discovery_.find_bench(number);
  if (!bench) return bench.outcome();
  const Target target = target_of(*bench);
  if (!may_command()) return target;  // can still read everything published
  if (const auto link = open(target, "requests"); !link) return link.outcome();
  return target;
}

BenchLinks::Link& BenchLinks::link_of(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  return links_[key];
}

/// @return the participant that has received our messages to this run; none before the first match.
wire::Source BenchLinks::reached_source_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  const auto link = links_.find(key);
  return link == links_.end() ? wire::Source{} : link->second.source;
}

/// Waits until all four queues are matched at both ends: a message sent before that would never
/// arrive.
bool BenchLinks::is_matched(const wire::Source& source, milliseconds patience) {
  return request_publication_->wait_for_match(source, patience) &&
         command_publication_->wait_for_match(source, patience) &&
         reply_reader_->matches().wait_for(source, patience) &&
         command_reply_subscription_.wait_for_match(source, patience);
}

Result<OpenLink> BenchLinks::open(const Target& target, std::string_view what,
                                  milliseconds patience) {
  if (is_closed_) return Outcome::failed(kSessionEnded);
  if (!may_command()) return not_permitted(target);
  OpenLink link{.key = target.key, .sending = std::unique_lock(link_of(target.key).mutex)};
  const auto deadline = Clock::now() + patience;
  // In short waits, because the bench may end or its wire may be replaced while we wait.
  while (!reconnect(target.key, kCheckSource)) {
    if (Outcome present = discovery_.check_presence(target); !present) return present;
    if (Clock::now() >= deadline) {
      return Outcome::lost(name_of(target) + " was found, but it cannot receive " +
                           std::string(what) + ": DDS has not matched its reader");
    }
  }
  link.is_matched = true;
  return link;
}

OpenLink BenchLinks::try_open(const BenchKey& key) {
  OpenLink link{.key = key, .sending = {link_of(key).mutex, std::try_to_lock}};
  link.is_matched = link.sending && reconnect(key, milliseconds(0));
  return link;
}

/// Called with the mutex of the link, before anything is sent: if another participant now sends for
/// the run, waits for a match with it and sends it all unanswered messages again.
/// @return whether the link is open.
bool BenchLinks::reconnect(const BenchKey& key, milliseconds patience) {
  const auto source = discovery_.source_of(key);
  if (!source || reached_source_of(key) == *source) return true;
  if (!is_matched(*source, patience) || !repeat(key, Clock::time_point::max())) return false;
  const std::scoped_lock lock(mutex_);
  links_[key].source = *source;
  return true;
}

// ---- sending ---------------------------------------------------------------------------------

/// Repeats the unanswered messages last sent before `sent_before`, in order and with their numbers.
/// @return false if a queue is full.
bool BenchLinks::repeat(const BenchKey& key, Clock::time_point sent_before) {
  const std::vector<msg::CommandFrame> frames = unanswered_.frames.to_repeat(key, sent_before);
  const std::vector<msg::Request> requests = unanswered_.requests.to_repeat(key, sent_before);
  // Frames first: a step names the last frame before it, and the bench waits for that frame.
  return std::ranges::all_of(frames,
                             [this](const msg::CommandFrame& frame) {
                               return command_publication_->write(frame);
                             }) &&
         std::ranges::all_of(requests, [this](const msg::Request& request) {
           return request_publication_->write(request);
         });
}

/// @return whether the participant that sends for the run is not the one that received our
///         messages.
bool BenchLinks::is_broken(const BenchKey& key) const {
  const wire::Source reached = reached_source_of(key);
  if (reached == wire::Source{}) return false;
  const auto source = discovery_.source_of(key);
  return source && *source != reached;
}

bool BenchLinks::repair(const BenchKey& key) {
  // Nothing is repeated to a silent bench: its queues would fill with messages that it already has.
  const bool was_broken = is_broken(key);
  const auto late = Clock::now() - kRepeatAfter;
  const bool is_overdue =
      (unanswered_.requests.has_due(key, late) || unanswered_.frames.has_due(key, late)) &&
      discovery_.is_alive(key, kPresence);
  if (is_closed_ || !may_command() || (!was_broken && !is_overdue)) return was_broken;
  if (const OpenLink link = try_open(key)) (void)repeat(key, Clock::now() - kRepeatAfter);
  return was_broken;
}

template <typename Message>
bool BenchLinks::send_patiently(wire::Publication<Message>& publication, const OpenLink& link,
                                const Message& message) {
  // The locks of this link stay held during the wait; no handler takes them.
  const auto is_sent = [&] {
    return participant_.make_room(link.key.number) && publication.write(message);
  };
  if (is_sent()) return true;
  const auto deadline = Clock::now() + kFullQueue;
  while (!is_sent()) {
    if (Clock::now() >= deadline || !discovery_.is_alive(link.key, discovery_.silence())) {
      return false;
    }
  }
  return true;
}

bool BenchLinks::send(const OpenLink& link, const msg::Request& request) {
  return send_patiently(*request_publication_, link, request);
}

bool BenchLinks::send(const OpenLink& link, const msg::CommandFrame& frame) {
  return send_patiently(*command_publication_, link, frame);
}

bool BenchLinks::send_keep_alive(const BenchKey& key) {
  if (is_closed_) return true;
  // Busy: a frame or a request is being sent, which serves as a keep-alive.
  const auto sending = held_axes_.try_lock_sending(key.number);
  if (!sending) return true;
  const OpenLink link = try_open(key);
  if (!link.sending) return true;
  if (!link.is_matched) return false;
  const auto frame = held_axes_.next_keep_alive(key);
  if (frame) (void)command_publication_->write(*frame);  // if refused, the next follows in 25 ms
  return true;
}

}  // namespace vdrive::client
