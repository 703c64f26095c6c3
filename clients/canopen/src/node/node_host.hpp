// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <span>

namespace vdrive::canopen {

/// An object of the drive with a value.
struct DriveValue {
  ObjectAddress object;
  std::int64_t value = 0;

  friend bool operator==(const DriveValue&, const DriveValue&) = default;
};

/// An SDO access of a master to an object of the drive.
struct DriveAccess {
  std::uint32_t ticket = 0;  ///< unique in this node; Node::complete() refers to it
  ObjectAddress object;
  std::optional<std::int64_t> value{};  ///< to write; none = read

  friend bool operator==(const DriveAccess&, const DriveAccess&) = default;
};

/// The result of a DriveAccess.
struct DriveAnswer {
  AbortCode abort = AbortCode::none;
  std::int64_t value = 0;  ///< value read

  friend bool operator==(const DriveAnswer&, const DriveAnswer&) = default;
};

/// The callbacks of a node. They are called within a call of the node, in its thread; they must not
/// block, and must not call the node.
class NodeHost {
 public:
  virtual ~NodeHost() = default;

  /// Sends a frame on the bus. The node does not receive it.
  virtual void send(const Frame& frame) = 0;

  /// Begins to read or write an object of the drive. Node::complete() delivers the answer; a node
  /// has at most one pending access.
  virtual void begin_access(const DriveAccess& access) = 0;

  /// Set-points of RPDOs, in order, each object once: they act together in the next tick, the
  /// controlword (6040h) last. Values of several nodes that arrive before the host hands them over
  /// act in the same tick.
  virtual void command(std::span<const DriveValue> values) = 0;

  /// The node has lost its master (heartbeat lost, NMT stop or reset): the drive reacts per 6007h
  /// to each call with true. False: the node has a master again.
  virtual void set_connection_lost(bool is_lost) = 0;

  /// NMT reset node: the drive is switched off and on.
  virtual void power_cycle() = 0;

  /// Stores the communication parameters for the node's next power-up: on 1010h:01 and 1011h:01,
  /// once the drive has saved or restored its own. The master is answered only afterwards.
  /// @return false if they could not be written: the master gets the abort 06060000h
  [[nodiscard]] virtual bool store(const std::map<ObjectAddress, std::uint32_t>& parameters) = 0;
};

}  // namespace vdrive::canopen
