// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/bench.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// What `describe` shows of one axis: what its bench publishes about it, and what was read from it.
struct AxisDescription {
  const client::BenchInfo& bench;
  const client::AxisInfo& axis;
  const client::AxisSnapshot& status;
  const client::Readings& readings;           ///< of described_objects()
  std::optional<std::uint64_t> fault_tick{};  ///< of last_fault_of(); none = not known
};

/// @return the objects that a description needs beside the status: every object that can be
/// written,
///         except those that act on memory and history (1010h, 1011h, 1003h:0), the newest error of
///         the history (1003h:1) and the type of the motor (6402h). They are one request.
[[nodiscard]] const std::vector<ObjectAddress>& described_objects();

/// @return the code of the newest fault in the history (1003h:1); where the history was emptied
/// that
///         of the present fault (603Fh); nothing without either.
[[nodiscard]] std::optional<std::uint16_t> last_fault_of(const client::AxisSnapshot& status,
                                                         const client::Readings& readings);

/// @return the description as the object that `describe --json` prints.
[[nodiscard]] Json description_json(const AxisDescription& described);

/// @return the same as lines of text: those of `status`, and what follows them.
[[nodiscard]] std::vector<std::string> description_text(const AxisDescription& described);

}  // namespace vdrive::tool
