// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <memory>
#include <string>

namespace vdrive::wire {

/// Creates a participant that reaches a network. @throws as make_participant
using ParticipantMaker = std::unique_ptr<Participant> (*)(const NetworkSettings& settings,
                                                          const std::string& name);

/// Priority of functions that register a maker of participants: before the constructors of all
/// static objects, which may create a participant.
inline constexpr int kBeforeConstructors = 101;

/// Sets the maker of participants without a local bus. The library that has the maker calls this at
/// program start, so that programs only need to link it.
void provide_network_participant(ParticipantMaker maker) noexcept;

/// @throws NetworkError when no library of this program provides network participants
[[nodiscard]] std::unique_ptr<Participant> make_network_participant(const NetworkSettings& settings,
                                                                    const std::string& name);

}  // namespace vdrive::wire
