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

/// A number that no bench has, so that all readers except the wire ignore the sample.
constexpr std::uint32_t kNoBench = 0;

wire::NetworkSettings probe_settings(wire::NetworkSettings settings) {
  settings.role = wire::Role::client;  // so that it does not discover clients
  return settings;
}

}  // namespace

class WireProbe::Endpoints {
 public:
  Endpoints(wire::Participant& participant, const wire::Source& wire)
      : wire_(wire),
        states_(participant,
                [this](const msg::BenchState& /*state*/, const wire::Source& source) {
                  const std::lock_guard lock(mutex_);
                  has_received_ = has_received_ || source == wire_;
                  changed_.notify_one();
                }),
        publication_(participant) {}

  [[nodiscard]] bool finds_the_wire() {
    return publication_.wait_for_match(wire_, std::chrono::milliseconds(kPatience));
  }

  /// Sends until a sample of the wire was received and `has_arrived()` is true.
  /// @return false after `deadline`
  template <typename Condition>
  [[nodiscard]] bool exchanges(Clock::time_point deadline, const Condition& has_arrived) {
    msg::BenchState state;
    state.bench = kNoBench;
    constexpr std::chrono::milliseconds kRepeat{50};  // the topic is best effort
    std::unique_lock lock(mutex_);
    has_received_ = false;  // samples received before this probe prove nothing
    while (Clock::now() < deadline) {
      if (has_received_ && has_arrived()) return true;
      lock.unlock();
      static_cast<void>(publication_.write(state));
      lock.lock();
      changed_.wait_for(lock, kRepeat);
    }
    return false;
  }

 private:
  const wire::Source wire_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool has_received_ = false;
  wire::Subscription<msg::BenchState> states_;
  wire::Publication<msg::BenchState> publication_;
};

WireProbe::WireProbe(wire::NetworkSettings settings, WireProgram& program)
    : program_(program),
      depends_on_server_(!settings.discovery_servers.empty()),
      participant_(wire::make_participant(probe_settings(std::move(settings)), "vdrive probe")) {
  program_.expect_probes_from(participant_->source());
}

WireProbe::~WireProbe() = default;

bool WireProbe::comes_through() {
  const auto deadline = Clock::now() + kPatience;
  const std::uint64_t before = program_.probes_received();
  if (!depends_on_server_) endpoints_.reset();
  if (endpoints_ == nullptr) {
    endpoints_ = std::make_unique<Endpoints>(*participant_, program_.participant().source());
  }
  if (!endpoints_->finds_the_wire()) {
    return depends_on_server_ && !was_found_ && !participant_->troubles().empty();
  }
  was_found_ = true;
  return endpoints_->exchanges(deadline, [this, before] {
    return program_.probes_received() != before;
  });
}

}  // namespace vdrive::service
