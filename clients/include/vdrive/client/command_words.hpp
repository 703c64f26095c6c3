// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::client {

/// Transitions that EachCommand::enable may use.
struct EnablingWay {
  bool resets_fault = false;  ///< leave Fault by a fault reset
  bool keeps_power = false;   ///< leave Quick stop active by transition 16, if the drive has it
};

/// The controlwords (6040h) of a command.
/// @return the words that carry out the command from `state`, to be written one after the other;
///         empty if no controlword can
[[nodiscard]] std::vector<std::uint16_t> words_to(EachCommand command, PowerState state,
                                                  const EnablingWay& way = {});

/// A command as set-points for Session::send_set_points(), which neither waits nor steps a clock:
/// the words of words_to(), one per set-point, each to be sent in a separate frame. The last one of
/// EachCommand::enable also sets kStandingTargets to 0, so that the axis stays at rest whatever its
/// targets were.
[[nodiscard]] std::vector<SetPoint> set_points_to(EachCommand command, const AxisSnapshot& axis,
                                                  const EnablingWay& way = {});

}  // namespace vdrive::client
