// SPDX-License-Identifier: Apache-2.0
#include "exchange/session_names.hpp"

#include "vdrive/text.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstddef>
#include <utility>

namespace vdrive::client {
namespace {

// Number of places in the name table of a bench (topic bench_session); samples with a place beyond
// these are ignored.
constexpr auto kPlacesOfBench = static_cast<std::uint16_t>(wire::kSessionsOfBench);
constexpr auto kMostKnown = static_cast<std::size_t>(wire::kSessionsInDomain);
// Maximum number of sessions remembered as asked for: later calls do not wait for the same unknown
// name again.
constexpr std::size_t kMostAsked = 1'024;
// Longest time between two checks of the bench while waiting for a name.
constexpr std::chrono::milliseconds kLookPeriod{20};

std::string host_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return {};
  return name.data();
}

SessionName own_name(std::string program) {
  if (program.empty()) program = program_invocation_short_name;
  return {.program = std::move(program),
          .process = static_cast<std::uint32_t>(getpid()),
          .host = host_name()};
}

SessionName shown_name(const SessionName& name) {
  return {.program = escaped(name.program), .process = name.process, .host = escaped(name.host)};
}

}  // namespace

SessionNames::SessionNames(wire::Participant& participant, std::uint64_t session,
                           std::string program, const Discovery& discovery, Wakeup& wakeup)
    : participant_(participant),
      session_(session),
      own_(own_name(std::move(program))),
      discovery_(discovery),
      wakeup_(wakeup) {}

// ---- sending own name --------------------------------------------------------------------------

void SessionNames::introduce(std::uint32_t bench) {
  const std::scoped_lock lock(saying_);
  // Marked as done even if sending fails: control of the axes does not depend on it.
  if (!introduced_.insert(bench).second) return;
  try {
    if (!publication_) {
      publication_ = std::make_unique<wire::Publication<msg::SessionName>>(participant_);
    }
  } catch (const wire::NetworkError&) {
    return;
  }
  msg::SessionName message;
  message.bench = bench;
  message.session = session_;
  message.program = own_.program;
  message.process = own_.process;
  message.host = own_.host;
  (void)publication_->write(message);
}

void SessionNames::finish() {
  const std::scoped_lock lock(saying_);
  if (!publication_) return;
  const auto end = Clock::now() + kMatchWait;
  const auto left = [end] {
    const auto rest = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    return std::max(rest, std::chrono::milliseconds(0));
  };
  for (const std::uint32_t bench : introduced_) {
    if (wakeup_.is_interrupted()) return;
    const auto target = discovery_.present_target(bench);
    const auto source = target ? discovery_.source_of(target->key) : std::nullopt;
    if (source) (void)publication_->wait_for_match(*source, left());
  }
  if (!wakeup_.is_interrupted()) (void)publication_->wait_for_acknowledged(left());
}

// ---- receiving names ---------------------------------------------------------------------------

void SessionNames::listen() {
  const std::scoped_lock lock(listening_);
  if (listens_since_ != Clock::time_point{}) return;
  listens_since_ = Clock::now();
  try {
    subscription_ = std::make_unique<wire::Subscription<msg::BenchSession>>(
        participant_, [this](const msg::BenchSession& message, const wire::Source& /*source*/) {
          on_name(message);
        });
  } catch (const wire::NetworkError&) {  // no permission: nothing will arrive
    listens_since_ -= kMatchWait;
  }
}

void SessionNames::on_name(const msg::BenchSession& message) {
  if (message.place >= kPlacesOfBench || !discovery_.sees(message.bench)) return;
  {
    const std::scoped_lock lock(mutex_);
    const Place place{message.bench, message.place};
    if (names_.size() >= kMostKnown && !names_.contains(place)) return;
    names_[place] = {.session = message.session,
                     .name = shown_name({.program = message.program.to_string(),
                                         .process = message.process,
                                         .host = message.host.to_string()})};
  }
  wakeup_.notify();
}

std::optional<SessionName> SessionNames::look_up(std::uint32_t bench, std::uint64_t session) const {
  const std::scoped_lock lock(mutex_);
  const auto first = names_.lower_bound({bench, 0});
  const auto end = names_.upper_bound({bench, kPlacesOfBench});
  const auto found = std::find_if(first, end, [session](const auto& row) {
    return row.second.session == session;
  });
  if (found == end) return std::nullopt;
  return found->second.name;
}

/// @return when the reader was first seen to be matched with this bench.
std::optional<SessionNames::Clock::time_point> SessionNames::time_of_match(std::uint32_t bench) {
  const auto target = discovery_.present_target(bench);
  const auto source = target ? discovery_.source_of(target->key) : std::nullopt;
  const std::scoped_lock lock(listening_);
  if (const auto known = matched_.find(bench); known != matched_.end()) return known->second;
  const bool is_matched = subscription_ && source &&
                          subscription_->wait_for_match(*source, std::chrono::milliseconds(0));
  if (!is_matched) return std::nullopt;
  return matched_.emplace(bench, Clock::now()).first->second;
}

SessionNames::Clock::time_point SessionNames::end_of_wait(std::uint32_t bench,
                                                          std::uint64_t session) {
  const auto matched = time_of_match(bench);
  if (!matched) {
    const std::scoped_lock lock(listening_);
    return listens_since_ + kMatchWait;
  }
  const std::scoped_lock lock(mutex_);
  if (asked_.size() >= kMostAsked) asked_.clear();
  const auto asked = asked_.emplace(session, Clock::now()).first->second;
  return std::max(*matched + kFirstWait, asked + kWait);
}

std::optional<SessionName> SessionNames::known(std::uint32_t bench, std::uint64_t session) {
  if (session == session_) return shown_name(own_);
  listen();
  return look_up(bench, session);
}

std::optional<SessionName> SessionNames::find(std::uint32_t bench, std::uint64_t session) {
  if (session == session_) return shown_name(own_);
  listen();
  while (true) {
    // Read before looking up, so that a later arrival ends the wait immediately.
    const std::uint64_t changes = wakeup_.changes();
    if (auto name = look_up(bench, session)) return name;
    if (wakeup_.work(changes, bench)) continue;
    if (!discovery_.may_be_there(bench)) return std::nullopt;
    const auto end = end_of_wait(bench, session);
    const auto now = Clock::now();
    if (now >= end || wakeup_.is_interrupted()) return std::nullopt;
    wakeup_.work_until(changes, bench, std::min(end, now + kLookPeriod));
  }
}

Outcome SessionNames::with_session_name(const Target& target, Outcome outcome) {
  const AxisOwner* const owner = outcome.owner();
  if (owner == nullptr || owner->name) return outcome;
  AxisOwner known = *owner;
  known.name = find(target.key.number, known.session);
  return known.name ? outcome.with_owner(std::move(known)) : outcome;
}

}  // namespace vdrive::client
