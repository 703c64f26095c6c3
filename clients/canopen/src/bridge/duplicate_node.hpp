// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node.hpp"

#include <functional>
#include <optional>

namespace vdrive::canopen {

/// A second device with the id of a node, by mistake: it boots, answers each SDO request, too, and
/// obeys NMT and SYNC. Its drive stands still: each object has its default, and what is written has
/// no effect.
class DuplicateNode final : private NodeHost {
 public:
  using Send = std::function<void(const Frame& frame)>;

  /// Boots.
  /// @param settings its texts are copied
  DuplicateNode(const NodeSettings& settings, Send send, DriveTime now);

  void receive(const Frame& frame, DriveTime now);
  void advance(DriveTime now);

 private:
  void send(const Frame& frame) override { send_(frame); }

  void begin_access(const DriveAccess& access) override { access_ = access; }

  void command(std::span<const DriveValue> /*values*/) override {}

  void set_connection_lost(bool /*is_lost*/) override {}

  void power_cycle() override {}

  bool store(const Node::Parameters& /*parameters*/) override { return true; }

  const Send send_;
  std::optional<DriveAccess> access_;  ///< not answered yet
  Node node_;
};

}  // namespace vdrive::canopen
