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

/// The data for `describe` of one axis: published by its bench, and read from it.
struct AxisDescription {
  const client::BenchInfo& bench;
  const client::AxisInfo& axis;
  const client::AxisSnapshot& status;
  const client::Readings& readings;           ///< values of described_objects()
  std::optional<std::uint64_t> fault_tick{};  ///< of last_fault_of(); none = not known
};

/// @return the objects that a description needs in addition to the status, in one request: every
///         writable object except those that act on memory and history (1010h, 1011h, 1003h:0), the
///         newest error of the history (1003h:1) and the motor type (6402h).
[[nodiscard]] const std::vector<ObjectAddress>& described_objects();

/// @return the code of the newest fault in the history (1003h:1); if the history was cleared, that
///         of the present fault (603Fh); nothing if there is neither.
[[nodiscard]] std::optional<std::uint16_t> last_fault_of(const client::AxisSnapshot& status,
                                                         const client::Readings& readings);

/// @return the object that `describe --json` prints.
[[nodiscard]] Json description_json(const AxisDescription& described);

/// @return the description as lines of text, starting with those of `status`.
[[nodiscard]] std::vector<std::string> description_text(const AxisDescription& described);

}  // namespace vdrive::tool
