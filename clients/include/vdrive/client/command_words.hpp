// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/axis.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::client {

/// What the way of EachCommand::enable may lead through.
struct EnablingWay {
  bool resets_fault = false;  ///< from Fault, by a fault reset
  bool keeps_power = false;  ///< from Quick stop active by transition 16, which not every drive has
};

/// The controlwords (6040h) of a command, for a program that sends them itself, such as by
/// Session::send_set_points(). With the last word of EachCommand::enable an axis follows what its
/// targets hold: it rests where kStandingTargets are 0.
/// @return the words that carry the command out from `state`, to be written one after the other;
///         none where no word would do
[[nodiscard]] std::vector<std::uint16_t> words_to(EachCommand command, PowerState state,
                                                  const EnablingWay& way = {});

}  // namespace vdrive::client
