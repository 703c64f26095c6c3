// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <memory>
#include <string>

namespace vdrive::wire {

/// Makes a participant that reaches a network. @throws what make_participant throws
using ParticipantMaker = std::unique_ptr<Participant> (*)(const NetworkSettings& settings,
                                                          const std::string& name);

/// Priority of functions that provide a maker of participants: before every constructor of a static
/// object, which may make a participant.
inline constexpr int kBeforeConstructors = 101;

/// Makes participants without a local bus use `maker`. A library that has one calls this while the
/// program starts: so no program that links it names it.
void provide_network_participant(ParticipantMaker maker) noexcept;

/// @throws NetworkError when no library of this program provides a participant
[[nodiscard]] std::unique_ptr<Participant> make_network_participant(const NetworkSettings& settings,
                                                                    const std::string& name);

}  // namespace vdrive::wire
