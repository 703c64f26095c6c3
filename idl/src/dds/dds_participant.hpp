// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <memory>
#include <string>

namespace vdrive::wire {

/// @return a participant of a DDS domain.
/// @throws what make_participant throws
[[nodiscard]] std::unique_ptr<Participant> make_dds_participant(const NetworkSettings& settings,
                                                                const std::string& name);

}  // namespace vdrive::wire
