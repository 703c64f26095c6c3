// SPDX-License-Identifier: Apache-2.0
// Drive time: what axes show now and later, in lock-step and by the status stream.
#include "session_core.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A running bench sends a sample of its status stream each tick; this allows for the match, and for
// a service that connects anew.
constexpr milliseconds kFirstSample{5000};

// Axis samples of a large bench take turns.
constexpr SessionCore::Patience kFirstSampleOfAll{milliseconds(5000), true};

/// Members of the status image that can be read as objects.
std::vector<StatusMember> readable_members() {
  std::vector<StatusMember> members;
  std::ranges::copy_if(status_members(), std::back_inserter(members), [](const auto& member) {
    return member.is_published && member.address.index != 0;
  });
  return members;
}

}  // namespace

bool SessionCore::is_interrupted() {
  const std::scoped_lock lock(mutex_);
  return interrupted_;
}

std::uint64_t SessionCore::last_sequence(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  return holding(key).sequence;
}

Result<Observation> SessionCore::observe(const Target& target,
                                         std::span<const std::uint16_t> axes) {
  if (!may_command()) return observe_published(target, axes);
  if (target.steps()) return step(target, 0, axes);
  if (target.is_paused) return read_status(target, axes);
  const auto feed = open_feed(target, {axes.begin(), axes.end()});
  auto sample = next(target, *feed, {kFirstSample, true, true});
  if (!sample && is_paused(target)) return read_status(target, axes);
  if (sample.outcome().kind() == OutcomeKind::timed_out) {
    return Outcome::timed_out(name_of(target) + " sends no status stream");
  }
  return sample;
}

/// While time stands still a bench sends no status frames, but goes on with its axis samples.
Result<Observation> SessionCore::observe_published(const Target& target,
                                                   std::span<const std::uint16_t> axes) {
  std::map<std::uint16_t, msg::AxisStatus> seen;
  const wire::Subscription<msg::AxisStatus> samples(
      participant_, [&](const msg::AxisStatus& message, const wire::Source& source) {
        if (message.bench() != target.key.number) return;
        const std::scoped_lock lock(mutex_);
        if (source != directory_.source_of(target.key)) return;
        seen.insert_or_assign(message.axis(), message);
        changed_.notify_all();
      });
  Lock lock(mutex_);
  const Outcome outcome = wait(lock, target, kFirstSampleOfAll, [&] {
    return std::ranges::all_of(axes, [&](std::uint16_t axis) {
      return seen.contains(axis);
    });
  });
  if (!outcome) return outcome;
  Observation observation;
  for (const std::uint16_t axis : axes) {
    observation.axes.push_back(snapshot_of(seen.at(axis)));
    observation.tick = std::max(observation.tick, seen.at(axis).tick());
  }
  lock.unlock();  // the end of the subscription waits for its handler
  return observation;
}

Result<Observation> SessionCore::read_status(const Target& target,
                                             std::span<const std::uint16_t> axes) {
  Observation observation;
  const std::vector<StatusMember> members = readable_members();
  for (const std::uint16_t axis : axes) {
    msg::Request request;
    request.kind(msg::REQUEST_READ);
    for (const StatusMember& member : members) {
      msg::ObjectAccess access;
      access.axis(axis);
      access.index(member.address.index);
      access.subindex(member.address.subindex);
      request.objects().push_back(access);
    }
    const auto reply =
        this->request(target, std::move(request), "status of " + name_of(target, axis));
    if (!reply) return reply.outcome();
    AxisSnapshot snapshot;
    snapshot.id = {target.key.number, axis};
    snapshot.tick = reply->tick();
    for (std::size_t i = 0; i < std::min(reply->objects().size(), members.size()); ++i) {
      members[i].set(snapshot.status, reply->objects()[i].value());
    }
    observation.tick = reply->tick();
    observation.axes.push_back(snapshot);
  }
  return observation;
}

std::shared_ptr<StatusFeed> SessionCore::open_feed(const Target& target,
                                                   std::vector<std::uint16_t> axes) {
  auto feed = std::make_shared<StatusFeed>(target.key, std::move(axes), target.status_every_ticks);
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(feeds_, [](const auto& weak) {
      return weak.expired();
    });
    feeds_.push_back(feed);
  }
  subscribe_status();
  return feed;
}

Result<std::uint64_t> SessionCore::present_tick(const Target& target) {
  if (target.steps() && may_command()) {
    const auto shown = step(target, 0, {});
    if (!shown) return shown.outcome();
    return shown->tick;
  }
  subscribe_status();
  const std::scoped_lock lock(mutex_);
  return directory_.tick(target.key);
}

Result<std::uint64_t> SessionCore::wait_for_tick(const Target& target, std::uint64_t tick) {
  if (target.steps()) {
    auto present = present_tick(target);
    if (!present || *present >= tick) return present;
    const auto reached = step(target, tick - *present, {});
    if (!reached) return reached.outcome();
    return reached->tick;
  }
  subscribe_status();
  Lock lock(mutex_);
  std::uint64_t reached = 0;
  const Outcome outcome = wait(lock, target, {std::chrono::hours(24 * 365), true, true}, [&] {
    reached = directory_.tick(target.key);
    return reached >= tick;
  });
  if (!outcome) return outcome;
  return reached;
}

void SessionCore::subscribe_status() {
  std::call_once(status_subscribed_, [this] {
    status_subscription_ = std::make_unique<wire::Subscription<msg::StatusFrame>>(
        participant_, [this](const msg::StatusFrame& message, const wire::Source& source) {
          on_status(message, source);
        });
  });
}

Result<Observation> SessionCore::next(const Target& target, StatusFeed& feed, Patience patience) {
  Lock lock(mutex_);
  std::optional<Observation> sample;
  const Outcome outcome = wait(lock, target, patience, [&] {
    sample = feed.take();
    return sample.has_value();
  });
  if (!outcome) return outcome;
  return std::move(*sample);
}

}  // namespace vdrive::client
