// SPDX-License-Identifier: Apache-2.0
#include "exchange/control.hpp"

#include "base/ask.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A small fraction of the usual watchdog time: several keep-alives may be lost or late.
constexpr milliseconds kKeepAlivePeriod{25};

// Short, because the watchdog of a bench keeps running while the bench reconnects.
constexpr milliseconds kRetry{5};

// Used if the system forbids a real-time policy; still puts the thread ahead of programs that
// compute.
constexpr int kNice = -10;

/// On a busy machine this thread must run before those that compute. If the system permits neither
/// a real-time policy nor kNice, the priority stays unchanged.
void raise_priority() {
  const sched_param lowest{.sched_priority = 1};
  if (sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &lowest) == 0) return;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

using namespace literals;

// Short, because the service may be gone already when the session ends.
constexpr milliseconds kReleaseAnswer{500};

constexpr ObjectAddress kControlword = kObjectRows["ds402_controlword"_object].address;

}  // namespace

Control::Control(KeepAlive keep_alive, Exchange& exchange, HeldAxes& held_axes,
                 CommandHistory& history, BenchLinks& links, SessionNames& names)
    : keep_alive_(keep_alive),
      exchange_(exchange),
      held_axes_(held_axes),
      history_(history),
      names_(names),
      links_(links) {}

Control::~Control() {
  end();
}

void Control::end() {
  // First: a keep-alive sent after the release would carry an outdated epoch.
  keep_alive_thread_.stop();
  (void)release();  // there is no caller to receive the outcome
}

/// Called with lock_sending() of the bench.
Result<RequestAnswer> Control::carry_out(const Target& target, msg::Request request,
                                         std::string_view what) {
  const msg::Request sent = request;
  auto reply = exchange_.request(target, std::move(request), what);
  if (reply) {
    history_.note_request(target.key, sent, *reply, held_axes_.last_sequence(target.key));
  }
  return reply;
}

Result<RequestAnswer> Control::exchange(const Target& target, msg::Request request,
                                        std::string_view what) {
  const auto sending = held_axes_.lock_sending(target.key.number);
  return carry_out(target, std::move(request), what);
}

void Control::note_acquired(const Target& target, std::span<const std::uint16_t> axes,
                            const msg::Reply& reply) {
  if (reply.epoch == 0) return;
  if (held_axes_.note_acquired(target.key, axes, reply.epoch, !target.steps())) {
    history_.note_gained(target.key, axes, held_axes_.last_sequence(target.key));
  }
  // In lock-step every tick is a sign of life, so no keep-alives are needed.
  if (keep_alive_ == KeepAlive::own_thread && !target.steps()) start_keep_alive();
}

bool Control::holds(const Target& target, std::span<const std::uint16_t> axes) {
  return held_axes_.holds(target.key, axes);
}

Outcome Control::acquire(const Target& target, std::span<const std::uint16_t> axes, bool by_force) {
  std::vector<std::uint16_t> held;
  std::vector<std::uint16_t> others;
  std::ranges::partition_copy(axes, std::back_inserter(held), std::back_inserter(others),
                              [&](std::uint16_t axis) {
                                return holds(target, {&axis, 1});
                              });
  if (held.empty() || others.empty()) return acquire_part(target, axes, by_force);
  // First a separate request for the axes already held: a new epoch then shows that one had been
  // lost. A request that gains axes always brings a new epoch.
  if (Outcome kept = acquire_part(target, held, by_force); !kept) return kept;
  return acquire_part(target, others, by_force);
}

Outcome Control::acquire_part(const Target& target, std::span<const std::uint16_t> axes,
                              bool by_force) {
  ask::Axes wanted(axes.begin(), axes.end());
  msg::Request request =
      by_force ? ask::take_over(std::move(wanted)) : ask::acquire(std::move(wanted));
  const std::string what =
      "control of " + (axes.size() == 1 ? name_of(target, axes.front()) : name_of(target));
  {
    // Held until the new epoch is recorded: a frame that another thread sends with the old epoch
    // would be refused.
    const auto sending = held_axes_.lock_sending(target.key.number);
    const auto reply = exchange_.request(target, std::move(request), what);
    if (!reply) return reply.outcome();
    note_acquired(target, axes, *reply);
  }
  names_.introduce(target.key.number);
  return {};
}

Result<RequestAnswer> Control::write(const Target& target, msg::Request request,
                                     std::string_view what) {
  const bool commands = std::ranges::any_of(request.objects, [](const msg::ObjectAccess& access) {
    return has_role({access.index, access.subindex}, Role::command);
  });
  // Storing waits for a disk and must not delay the keep-alives.
  if (!commands) return exchange_.request(target, std::move(request), what);
  const std::uint16_t axis = request.objects.front().axis;
  auto sending = held_axes_.lock_sending(target.key.number);
  auto reply = carry_out(target, std::move(request), what);
  const bool is_taken =
      reply && reply->objects.front().abort_code == msg::Reason::none && reply->epoch != 0;
  if (is_taken) note_acquired(target, {&axis, 1}, *reply);
  sending.unlock();
  if (is_taken) names_.introduce(target.key.number);
  return reply;
}

Result<std::uint64_t> Control::stop(const Target& target, std::span<const std::uint16_t> axes,
                                    std::uint16_t word) {
  std::vector<msg::Request> requests;
  for (const std::uint16_t axis : axes) {
    if (requests.empty() || requests.back().objects.size() == msg::MAX_OBJECTS_PER_REQUEST) {
      requests.push_back(ask::write({}));
    }
    requests.back().objects.push_back(ask::object(axis, kControlword, word));
  }
  const auto sending = held_axes_.lock_sending(target.key.number);
  const auto replies = exchange_.send_all(target, requests)
                           .await("stop of " + (axes.size() == 1 ? name_of(target, axes.front())
                                                                 : "axes of " + name_of(target)));
  if (!replies) return replies.outcome();
  for (std::size_t i = 0; i < replies->size(); ++i) {
    history_.note_request(target.key, requests[i], (*replies)[i],
                          held_axes_.last_sequence(target.key));
  }
  std::uint64_t tick = 0;
  for (const msg::Reply& reply : *replies) {
    tick = std::max(tick, reply.tick);
    for (const msg::ObjectResult& result : reply.objects) {
      if (result.abort_code != msg::Reason::none) {
        return Outcome::refused(wire::number(result.abort_code),
                                "stop of " + name_of(target, result.axis) + " refused");
      }
    }
    // Halting a free axis acquires it.
    if ((word & Controlword::kHalt) != 0) note_acquired(target, axes, reply);
  }
  return tick;
}

Outcome Control::release() {
  Outcome result;
  for (const ReleasedAxes& given : held_axes_.drop_all()) {
    if (Outcome released = release(given); !released) result = std::move(released);
  }
  return result;
}

Outcome Control::release(std::uint32_t bench) {
  const auto given = held_axes_.drop(bench);
  return given ? release(*given) : Outcome();
}

Outcome Control::release(const ReleasedAxes& given) {
  const Target target{.key = given.key};
  if (given.kept.empty()) {  // a request without axes means all axes
    return release(target, std::array<std::vector<std::uint16_t>, 1>{});
  }
  // One by one: a request that names an axis no longer held releases none.
  std::vector<std::vector<std::uint16_t>> parts;
  for (const std::uint16_t axis : given.axes) parts.push_back({axis});
  if (Outcome released = release(target, parts); !released) return released;
  const std::size_t others = given.kept.size() - 1;
  return Outcome::failed(name_of(target, given.kept.front()) +
                         (others == 0 ? " was" : " and " + std::to_string(others) + " more were") +
                         " not released, because no stop was seen; the watchdog of the bench acts "
                         "once this session is silent");
}

/// Also works after an interrupt, and waits only kReleaseAnswer for a service that may be gone.
Outcome Control::release(const Target& target, std::span<const std::vector<std::uint16_t>> parts) {
  const auto sending = held_axes_.lock_sending(target.key.number);
  std::vector<std::uint64_t> sent;
  Outcome result;
  for (const std::vector<std::uint16_t>& axes : parts) {
    const auto number = exchange_.send(target, ask::release(axes), kReleaseAnswer);
    if (!number) {
      result = number.outcome();
      break;
    }
    sent.push_back(*number);
  }
  for (const std::uint64_t number : sent) {
    const Patience patience{result ? kReleaseAnswer : std::chrono::milliseconds(0), false};
    const auto answered = exchange_.await(target, number, patience);
    if (!answered && result) result = answered.outcome();
  }
  // Whatever the reason for a failure, it is unknown whether the axes are free.
  if (result || result.kind() == OutcomeKind::lost) return result;
  return Outcome::lost(result.message());
}

/// Starts keep-alives to the benches that take axes away from a silent session. The first acquired
/// axis starts the thread: a session that only observes has none.
void Control::start_keep_alive() {
  std::call_once(keeps_alive_, [this] {
    keep_alive_thread_.start([this, is_raised = false]() mutable {
      if (!std::exchange(is_raised, true)) raise_priority();
      return send_keep_alive();
    });
  });
}

/// @return wall time until the next keep-alives.
milliseconds Control::send_keep_alive() {
  bool are_all_reached = true;
  for (const BenchKey& key : held_axes_.to_keep_alive()) {
    are_all_reached &= links_.send_keep_alive(key);
  }
  return are_all_reached ? kKeepAlivePeriod : kRetry;
}

}  // namespace vdrive::client
