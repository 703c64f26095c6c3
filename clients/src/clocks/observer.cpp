// SPDX-License-Identifier: Apache-2.0
#include "clocks/observer.hpp"

#include "base/ask.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace literals;

// A running bench sends a status sample each tick; the time allows for DDS matching and for a
// service that is reconnecting.
constexpr Patience kFirstSample{std::chrono::milliseconds(5000), true, true};

// The caller chose the tick, which may be far ahead: only an interrupt or a lost bench ends the
// wait.
constexpr Patience kAnyTick{std::chrono::hours(24 * 365), true, true, Silence::is_bridged};

// Maximum number of requests in flight, so that their answers do not overflow a queue.
constexpr std::size_t kReadsAtOnce = 16;

constexpr ObjectAddress kStatusword = kObjectRows["ds402_statusword"_object].address;

/// Members of the status image that can be read as objects.
std::vector<StatusMember> readable_members() {
  std::vector<StatusMember> members;
  std::ranges::copy_if(status_members(), std::back_inserter(members), [](const auto& member) {
    return member.is_published && member.address.index != 0;
  });
  return members;
}

msg::Request read_request(std::uint16_t axis, const std::vector<StatusMember>& members) {
  ask::Objects objects;
  objects.reserve(members.size());
  for (const StatusMember& member : members) objects.push_back(ask::object(axis, member.address));
  return ask::read(std::move(objects));
}

}  // namespace

Observer::Observer(const Discovery& discovery, BenchLinks& links, Exchange& exchange,
                   BenchClocks& clocks, StatusStream& stream)
    : discovery_(discovery), links_(links), exchange_(exchange), clocks_(clocks), stream_(stream) {}

Result<Observation> Observer::observe(const Target& target, std::span<const std::uint16_t> axes) {
  if (!links_.may_command()) return stream_.next_samples(target, axes);
  if (target.steps()) return clocks_.step(target, 0, axes);
  if (target.is_paused) return read_status(target, axes);
  const auto feed = stream_.open_feed(target, {axes.begin(), axes.end()});
  return observe(target, axes, *feed);
}

Result<Observation> Observer::observe(const Target& target, std::span<const std::uint16_t> axes,
                                      StatusFeed& feed) {
  auto sample = stream_.next(target, feed, kFirstSample);
  if (!sample && discovery_.is_paused(target.key)) return observe_at_rest(target, axes);
  if (sample.outcome().kind() == OutcomeKind::timed_out) {
    return Outcome::timed_out(name_of(target) + " sends no status stream");
  }
  return sample;
}

/// A bench sends no status frames while time stands still.
Result<Observation> Observer::observe_at_rest(const Target& target,
                                              std::span<const std::uint16_t> axes) {
  return links_.may_command() ? read_status(target, axes) : stream_.next_samples(target, axes);
}

Result<Observation> Observer::read_status(const Target& target,
                                          std::span<const std::uint16_t> axes) {
  Observation observation;
  observation.axes.reserve(axes.size());
  const std::vector<StatusMember> members = readable_members();
  for (auto left = axes; !left.empty();) {
    const auto some = left.first(std::min(left.size(), kReadsAtOnce));
    left = left.subspan(some.size());
    std::vector<msg::Request> requests;
    requests.reserve(some.size());
    for (const std::uint16_t axis : some) requests.push_back(read_request(axis, members));
    const std::string whose =
        axes.size() == 1 ? name_of(target, some.front()) : "axes of " + name_of(target);
    const auto replies =
        exchange_.send_all(target, std::move(requests)).await("status of " + whose);
    if (!replies) return replies.outcome();
    for (std::size_t i = 0; i < some.size(); ++i) {
      const RequestAnswer& reply = (*replies)[i];
      AxisSnapshot& sample = observation.axes.emplace_back();
      sample.id = {target.key.number, some[i]};
      sample.tick = reply.tick;
      sample.has_owner = false;  // no object contains the owner
      for (std::size_t at = 0; at < std::min(reply.objects.size(), members.size()); ++at) {
        members[at].set(sample.status, reply.objects[at].value);
      }
      observation.tick = reply.tick;
    }
  }
  return observation;
}

Result<std::uint64_t> Observer::present_tick(const Target& target, Silence silence) {
  if (target.steps() && links_.may_command()) {
    const auto shown = clocks_.step(target, 0, {}, kStepPatience, silence);
    if (!shown) return shown.outcome();
    return shown->tick;
  }
  stream_.subscribe();
  return discovery_.tick(target.key);
}

/// The bench answers a read between two ticks, with the last completed one.
Result<std::uint64_t> Observer::completed_tick(const Target& target, std::uint16_t axis) {
  if (!links_.may_command()) return 0;
  const auto reply = exchange_.request(target, ask::read({ask::object(axis, kStatusword)}),
                                       "status of " + name_of(target, axis));
  if (!reply) return reply.outcome();
  return reply->tick;
}

std::uint64_t Observer::first_tick_of_stream(const Target& target, std::uint16_t axis) {
  if (discovery_.may_be_ahead(target.key)) {
    if (const auto tick = completed_tick(target, axis)) return *tick;
  }
  return discovery_.tick(target.key);
}

Result<std::uint64_t> Observer::wait_for_tick(const Target& target, std::uint64_t tick) {
  if (target.steps()) {
    auto present = present_tick(target, Silence::is_bridged);
    if (!present || *present >= tick) return present;
    const auto reached =
        clocks_.step(target, tick - *present, {}, kStepPatience, Silence::is_bridged);
    if (!reached) return reached.outcome();
    return reached->tick;
  }
  stream_.subscribe();
  std::uint64_t reached = 0;
  const Outcome outcome = links_.wait(target, kAnyTick, [&] {
    reached = discovery_.tick(target.key);
    return reached >= tick;
  });
  if (!outcome) return outcome;
  return reached;
}

Result<std::uint64_t> Observer::wait_for_ticks(const Target& target, std::uint64_t ticks) {
  if (target.steps()) {
    const auto present = present_tick(target, Silence::is_bridged);
    return present ? wait_for_tick(target, *present + ticks) : present;
  }
  stream_.subscribe();
  std::optional<std::uint64_t> last;
  Outcome outcome = links_.wait(target, kAnyTick, [&] {
    const auto now = discovery_.driven_tick(target.key);
    if (now && !last) last = *now + ticks;
    return last && now >= last;
  });
  if (!outcome) return outcome;
  return discovery_.tick(target.key);
}

}  // namespace vdrive::client
