// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <memory>
#include <string>

namespace vdrive::wire {

/// @return a participant of a DDS domain.
/// @throws as make_participant
[[nodiscard]] std::unique_ptr<Participant> make_dds_participant(const NetworkSettings& settings,
                                                                const std::string& name);

}  // namespace vdrive::wire
