// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::client {

/// What the way of EachCommand::enable may lead through.
struct EnablingWay {
  bool resets_fault = false;  ///< from Fault, by a fault reset
  bool keeps_power = false;  ///< from Quick stop active by transition 16, which not every drive has
};

/// The controlwords (6040h) of a command.
/// @return the words that carry the command out from `state`, to be written one after the other;
///         none where no word would do
[[nodiscard]] std::vector<std::uint16_t> words_to(EachCommand command, PowerState state,
                                                  const EnablingWay& way = {});

/// A command for Session::send_set_points(), which neither waits nor steps a clock: words_to(), one
/// a set-point, each in a frame of its own. The last of EachCommand::enable also sets
/// kStandingTargets to 0: the axis rests, whatever its targets held.
[[nodiscard]] std::vector<SetPoint> set_points_to(EachCommand command, const AxisSnapshot& axis,
                                                  const EnablingWay& way = {});

}  // namespace vdrive::client
