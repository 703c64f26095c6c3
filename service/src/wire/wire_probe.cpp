// SPDX-License-Identifier: Apache-2.0
#include "wire/wire_probe.hpp"

#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

namespace vdrive::service {
namespace {

using Clock = std::chrono::steady_clock;

/// A number that no bench has: every reader but the wire ignores the sample.
constexpr std::uint32_t kNoBench = 0;

wire::NetworkSettings of_a_probe(wire::NetworkSettings settings) {
  settings.role = wire::Role::client;  // clients are nothing to it
  return settings;
}

}  // namespace

WireProbe::WireProbe(wire::NetworkSettings settings, WireProgram& program)
    : program_(program),
      participant_(wire::make_participant(of_a_probe(std::move(settings)), "vdrive probe")) {
  program_.expect_probes_from(participant_->source());
}

bool WireProbe::comes_through() {
  const wire::Source wire = program_.participant().source();
  const std::uint64_t before = program_.probes_received();
  std::mutex mutex;
  std::condition_variable changed;
  bool has_received = false;
  const wire::Subscription<msg::BenchState> states(
      *participant_, [&](const msg::BenchState&, const wire::Source& source) {
        const std::lock_guard lock(mutex);
        has_received = has_received || source == wire;
        changed.notify_one();
      });
  wire::Publication<msg::BenchState> publication(*participant_);
  const auto deadline = Clock::now() + kPatience;
  if (!publication.wait_for_match(wire, std::chrono::milliseconds(kPatience))) return false;
  msg::BenchState state;
  state.bench = kNoBench;
  constexpr std::chrono::milliseconds kRepeat{50};  // best effort
  std::unique_lock lock(mutex);
  while (Clock::now() < deadline) {
    if (has_received && program_.probes_received() != before) return true;
    lock.unlock();
    static_cast<void>(publication.write(state));
    lock.lock();
    changed.wait_for(lock, kRepeat);
  }
  return false;
}

}  // namespace vdrive::service
