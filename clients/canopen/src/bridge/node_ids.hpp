// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

namespace vdrive::canopen {

/// Assigns axes to the nodes of a bus: node id = number of the axis + offset of its bench.
class NodeIds {
 public:
  /// Adds the axes of a bench as nodes: all of them or none.
  /// @return why it cannot: an id is out of range or already taken by another axis; nothing on
  ///         success
  [[nodiscard]] std::optional<std::string> add(std::span<const client::AxisInfo> axes,
                                               std::int32_t offset);

  /// Removes the nodes of that bench.
  void remove(std::uint32_t bench);

  [[nodiscard]] bool contains(std::uint8_t id) const { return axes_.contains(id); }

  /// @return such as "1 node (5)" or "5 nodes (1 to 3, 11 to 12)".
  [[nodiscard]] std::string text() const;

 private:
  std::map<std::uint8_t, client::AxisId> axes_;  ///< by node id
};

/// @return the node id of an axis. @pre NodeIds::add() has taken it
[[nodiscard]] std::uint8_t node_id_of(const client::AxisId& axis, std::int32_t offset) noexcept;

}  // namespace vdrive::canopen
