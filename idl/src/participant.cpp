// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/participant.hpp"

#include "local/local_participant.hpp"
#include "network_participant.hpp"

namespace vdrive::wire {

std::unique_ptr<Participant> make_participant(const NetworkSettings& settings,
                                              const std::string& name) {
  if (settings.bus == nullptr) return make_network_participant(settings, name);
  return std::make_unique<LocalParticipant>(settings.bus, settings.role, name);
}

}  // namespace vdrive::wire
