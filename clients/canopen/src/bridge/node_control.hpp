// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "control_keeper.hpp"
#include "reports.hpp"
#include "vdrive/client/session.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// @return the axes of a bench, in their order.
[[nodiscard]] std::vector<client::AxisId> ids_of(const client::BenchInfo& info);

/// Keeps control of all axes of a bench for its nodes: takes it as soon as they are free, and again
/// after a loss. For the one thread that may wait for the bench.
class NodeControl {
 public:
  /// @param session, reports outlive this
  /// @param axes all of a bench
  NodeControl(client::Session& session, std::vector<client::AxisId> axes, std::string label,
              bridge::Reports& reports);

  /// Does what is due; waits for the bench where control has to be taken.
  /// @return the state of the axes after it was taken; none when it was not.
  std::optional<client::Observation> keep(std::span<const client::AxisSnapshot> axes);

 private:
  client::Session& session_;
  const std::vector<client::AxisId> axes_;
  bridge::ControlKeeper keeper_;
};

}  // namespace vdrive::canopen
