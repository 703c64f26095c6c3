// SPDX-License-Identifier: Apache-2.0
#include "wire/closed_check.hpp"

#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <memory>
#include <string>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

/// Authentication takes some 40 ms, more on a busy machine.
constexpr std::chrono::milliseconds kLongestMatch = 5s;
/// How long the stranger, which starts before the member, keeps trying after the member has
/// matched.
constexpr std::chrono::milliseconds kLeeway = 100ms;

/// A participant that publishes and subscribes to bench_state.
class Visitor {
 public:
  Visitor(const wire::NetworkSettings& settings, const std::string& name)
      : participant_(wire::make_participant(settings, name)),
        states_(*participant_, [](const msg::BenchState&, const wire::Source&) {}),
        own_states_(*participant_) {}

  /// @return whether it receives from `other`.
  [[nodiscard]] bool receives_from(const wire::Source& other, std::chrono::milliseconds patience) {
    return states_.wait_for_match(other, patience);
  }

  /// @return whether `other` receives from it.
  [[nodiscard]] bool is_received_by(const wire::Source& other, std::chrono::milliseconds patience) {
    return own_states_.wait_for_match(other, patience);
  }

 private:
  std::unique_ptr<wire::Participant> participant_;
  wire::Subscription<msg::BenchState> states_;
  wire::Publication<msg::BenchState> own_states_;
};

wire::NetworkSettings without_material(wire::NetworkSettings settings) {
  settings.security.clear();
  return settings;
}

}  // namespace

void check_closed(wire::Participant& participant, const wire::NetworkSettings& settings) {
  const wire::Source bench = participant.source();
  Visitor stranger(without_material(settings), "vdrived self-test: stranger");
  Visitor member(settings, "vdrived self-test: member");
  if (!member.receives_from(bench, kLongestMatch) || !member.is_received_by(bench, kLongestMatch)) {
    throw wire::NetworkError(
        "network security: self-test: a participant with the credentials of this service cannot "
        "discover it; check that its permissions allow every topic of a service");
  }
  if (stranger.receives_from(bench, kLeeway) || stranger.is_received_by(bench, 0ms)) {
    throw wire::NetworkError(
        "network security: self-test: a participant without credentials discovers this service, so "
        "the bench is open; check that the DDS library of this machine has DDS Security");
  }
}

}  // namespace vdrive::service
