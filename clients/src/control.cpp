// SPDX-License-Identifier: Apache-2.0
#include "control.hpp"

#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

constexpr std::chrono::milliseconds kReleaseAnswer{500};

}  // namespace

Control::Control(KeepAlive keep_alive, Requests& requests, Holdings& holdings,
                 Connection& connection)
    : keep_alive_(keep_alive),
      requests_(requests),
      holdings_(holdings),
      keep_alive_sender_(holdings, connection) {}

Control::~Control() {
  keep_alive_sender_.stop();
  (void)release();  // nobody is left to receive the outcome
}

Result<msg::Reply> Control::exchange(const Target& target, msg::Request request,
                                     std::string_view what) {
  const auto sending = holdings_.lock_sending(target.key.number);
  return requests_.exchange(target, std::move(request), what);
}

void Control::note_acquired(const Target& target, std::span<const std::uint16_t> axes,
                            const msg::Reply& reply) {
  if (reply.epoch() == 0) return;
  holdings_.note_acquired(target.key, axes, reply.epoch(), !target.steps());
  if (keep_alive_ == KeepAlive::own_thread) keep_alive_sender_.start();
}

bool Control::holds(const Target& target, std::span<const std::uint16_t> axes) {
  return holdings_.holds(target.key, axes);
}

Outcome Control::acquire(const Target& target, std::span<const std::uint16_t> axes) {
  msg::Request request;
  request.kind(msg::REQUEST_ACQUIRE);
  request.axes().assign(axes.begin(), axes.end());
  const std::string what =
      "control of " + (axes.size() == 1 ? name_of(target, axes.front()) : name_of(target));
  const auto reply = exchange(target, std::move(request), what);
  if (!reply) return reply.outcome();
  note_acquired(target, axes, *reply);
  return {};
}

Result<msg::Reply> Control::write(const Target& target, msg::Request request,
                                  std::string_view what) {
  const bool commands = std::ranges::any_of(request.objects(), [](const msg::ObjectAccess& access) {
    return has_role({access.index(), access.subindex()}, Role::command);
  });
  // A store waits for a disk: it must not hold up the keep-alives.
  if (!commands) return requests_.exchange(target, std::move(request), what);
  const std::uint16_t axis = request.objects().front().axis();
  auto reply = exchange(target, std::move(request), what);
  if (reply && reply->objects().front().abort_code() == 0) {
    note_acquired(target, {&axis, 1}, *reply);
  }
  return reply;
}

Outcome Control::release() {
  Outcome result;
  for (const BenchKey& key : holdings_.drop_all()) {
    // Also after an interrupt, and to a service that may be gone: with a patience of its own.
    const auto sending = holdings_.lock_sending(key.number);
    const Target target{.key = key};
    msg::Request request;
    request.kind(msg::REQUEST_RELEASE);
    const auto sent = requests_.send(target, std::move(request), kReleaseAnswer);
    if (!sent || !requests_.await(target, *sent, {kReleaseAnswer, false})) {
      result = Outcome::lost(name_of(target) + " did not answer");
    }
  }
  return result;
}

}  // namespace vdrive::client
