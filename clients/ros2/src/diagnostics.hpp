// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "board.hpp"
#include "vdrive/wire/ros_types.hpp"

#include <string>

namespace vdrive::ros2 {

/// @return one status per bench and per joint.
/// @param network "loopback only", or the addresses that the bridge uses
[[nodiscard]] ros::DiagnosticArray diagnostics_of(const Board::Views& views,
                                                  const std::string& network);

/// @return the levels and messages of these diagnostics: when they change, they are published
///         immediately.
[[nodiscard]] std::string levels_of(const Board::Views& views);

}  // namespace vdrive::ros2
