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

/// A value for an object of the drive.
struct DriveValue {
  ObjectAddress object;
  std::int64_t value = 0;

  friend bool operator==(const DriveValue&, const DriveValue&) = default;
};

/// An access of a master to an object of the drive, by SDO.
struct DriveAccess {
  std::uint32_t ticket = 0;  ///< of this node; Node::complete() names it
  ObjectAddress object;
  std::optional<std::int64_t> value{};  ///< to write; none = read

  friend bool operator==(const DriveAccess&, const DriveAccess&) = default;
};

/// What became of it.
struct DriveAnswer {
  AbortCode abort = AbortCode::none;
  std::int64_t value = 0;  ///< that was read

  friend bool operator==(const DriveAnswer&, const DriveAnswer&) = default;
};

/// What a node does to the world around it. A function is called within a call of the node, by its
/// thread; it returns at once, and calls no function of the node.
class NodeHost {
 public:
  virtual ~NodeHost() = default;

  /// Puts a frame on the bus. The node does not receive it.
  virtual void send(const Frame& frame) = 0;

  /// Begins to read or write an object of the drive. Node::complete() brings the answer; a node has
  /// at most one access under way.
  virtual void begin_access(const DriveAccess& access) = 0;

  /// Set-points of RPDOs, in order, each object once: they act together in the next tick, the
  /// controlword (6040h) last. Values passed for several nodes before the host hands over act in
  /// one tick.
  virtual void command(std::span<const DriveValue> values) = 0;

  /// The node has lost its master (heartbeat lost, NMT stop or reset): the drive reacts as 6007h
  /// says, to each call with true. `is_lost` = false when it has a master again.
  virtual void set_connection_lost(bool is_lost) = 0;

  /// NMT reset node: the drive is switched off and on.
  virtual void power_cycle() = 0;

  /// Keeps the communication parameters that the node has at its next power-up: 1010h:01 and
  /// 1011h:01, when the drive has saved or restored its own. The master gets its answer after it.
  /// @return false when they could not be written: the master gets the abort 06060000h
  [[nodiscard]] virtual bool store(const std::map<ObjectAddress, std::uint32_t>& parameters) = 0;
};

}  // namespace vdrive::canopen
