// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "terminal.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <map>
#include <string>
#include <vector>

namespace vdrive::tool {

/// What `watch` shows on a terminal: a line with the tick, a header, and one row an axis. A wider
/// terminal gets more columns; 60 are enough for position, velocity and state with what the
/// statusword says. No row is wider than the terminal, and there are no more rows than it has.
[[nodiscard]] std::vector<LiveLine> watch_table(const client::Observation& sample,
                                                const std::map<client::AxisId, std::string>& names,
                                                const TerminalSize& size);

}  // namespace vdrive::tool
