// SPDX-License-Identifier: Apache-2.0
// Drive time: what axes show now and later, in lock-step and by the status stream.
#include "session_core.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <type_traits>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A running bench sends a sample of its status stream each tick; this allows for the match, and for
// a service that connects anew.
constexpr milliseconds kFirstSample{5000};

// Axis samples of a large bench take turns.
constexpr SessionCore::Patience kFirstSampleOfAll{milliseconds(5000), true};

/// An object of the status image, as a read answers it.
struct StatusObject {
  std::uint16_t index;
  void (*set)(AxisStatus& status, std::int64_t value);
};

/// Writes `value` to a member, whose type holds every value of the object.
template <auto kMember>
void set_member(AxisStatus& status, std::int64_t value) {
  status.*kMember = static_cast<std::remove_reference_t<decltype(status.*kMember)>>(value);
}

constexpr std::array<StatusObject, 20> kStatusObjects{{
    {0x6062, set_member<&AxisStatus::position_demand_value>},
    {0x6064, set_member<&AxisStatus::load_position_actual_value>},
    {0x60F4, set_member<&AxisStatus::load_position_error_value>},
    {0x3572, set_member<&AxisStatus::motor_position_actual_value>},
    {0x3573, set_member<&AxisStatus::motor_position_error_value>},
    {0x606B, set_member<&AxisStatus::velocity_demand_value>},
    {0x606C, set_member<&AxisStatus::load_velocity_actual_value>},
    {0x351E, set_member<&AxisStatus::load_velocity_error_value>},
    {0x3574, set_member<&AxisStatus::motor_velocity_actual_value>},
    {0x3575, set_member<&AxisStatus::motor_velocity_error_value>},
    {0x351F, set_member<&AxisStatus::current_error_value>},
    {0x6078, set_member<&AxisStatus::current_actual_value>},
    {0x6077, set_member<&AxisStatus::torque_actual_value>},
    {0x6074, set_member<&AxisStatus::torque_demand>},
    {0x6041, set_member<&AxisStatus::ds402_statusword>},
    {0x603F, set_member<&AxisStatus::error_code>},
    {0x6061, set_member<&AxisStatus::op_mode_actual>},
    {0x3005, set_member<&AxisStatus::motor_op_status>},
    {0x1001, set_member<&AxisStatus::error_register>},
    {0x60FD, set_member<&AxisStatus::digital_inputs>},
}};

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
  for (const std::uint16_t axis : axes) {
    msg::Request request;
    request.kind(msg::REQUEST_READ);
    for (const StatusObject& object : kStatusObjects) {
      msg::ObjectAccess access;
      access.axis(axis);
      access.index(object.index);
      request.objects().push_back(access);
    }
    const auto reply =
        this->request(target, std::move(request), "status of " + name_of(target, axis));
    if (!reply) return reply.outcome();
    AxisSnapshot snapshot;
    snapshot.id = {target.key.number, axis};
    snapshot.tick = reply->tick();
    for (std::size_t i = 0; i < std::min(reply->objects().size(), kStatusObjects.size()); ++i) {
      kStatusObjects[i].set(snapshot.status, reply->objects()[i].value());
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
