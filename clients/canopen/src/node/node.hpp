// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/node_settings.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::canopen {

/// Counters of a node since its construction; an NMT reset does not clear them.
struct NodeCounters {
  std::uint64_t ignored_set_points = 0;  ///< RPDOs without effect because the bridge did not own
                                         ///< the axis; of a synchronous RPDO, only the last frame
                                         ///< before each SYNC counts
  std::uint64_t refused_set_points = 0;  ///< values of RPDOs that the drive has refused
  std::uint64_t dropped_pdos = 0;        ///< as PdoCounters::dropped
  std::uint64_t sdo_aborts = 0;          ///< sent by the node
  std::uint64_t sdo_time_outs = 0;       ///< transfers that the client did not continue
  std::uint64_t ignored_frames = 0;      ///< malformed frames with an identifier of this node or of
                                         ///< NMT
  std::uint64_t held_back_emergencies = 0;  ///< dropped because of the inhibit time 1015h
};

/// A CANopen node (CiA 301) of one axis (CiA 402): a function of frames, states and time. It does
/// no I/O, never waits, and reads no clock. For one thread.
///
/// At SYNC n, receive() sends the TPDOs with the status of the last update() (the drive at n), then
/// passes the RPDOs received before SYNC to NodeHost::command(): they act after n.
class Node {
 public:
  /// The communication parameters at power-up; see stored().
  using Parameters = std::map<ObjectAddress, std::uint32_t>;

  /// @param settings their texts are copied
  /// @param host outlives the node
  /// @param stored communication parameters saved by 1010h:01; empty = defaults. Entries that are
  ///        not communication parameters are ignored.
  Node(const NodeSettings& settings, NodeHost& host, Parameters stored = {});
  ~Node();
  Node(Node&&) noexcept;
  Node& operator=(Node&&) noexcept;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// The drive is present: sends boot-up and enters pre-operational. May be called again when the
  /// drive has been away: a pending access is then forgotten, and `now` may be earlier than before.
  void start(const DriveView& drive, DriveTime now);

  /// A frame on the bus, from any node; the node's own frames are ignored.
  void receive(const Frame& frame, DriveTime now);

  /// The status of the drive after a new tick: sends emergencies and change-driven PDOs.
  void update(const DriveView& drive, DriveTime now);

  /// Does everything that is due: heartbeat, heartbeat consumer, inhibit times, event timers, SDO
  /// time-outs.
  void advance(DriveTime now);

  /// The node's CAN controller has gone bus-off, or has recovered: a communication error (1029h:01,
  /// 6007h), which ends with the emergency 8140h. The host must drop the frames that the node sends
  /// in between.
  void set_bus_off(bool is_off, DriveTime now);

  /// @return when advance() is next due; none = no timer is running.
  [[nodiscard]] std::optional<DriveTime> next_due() const;

  /// The answer to NodeHost::begin_access(). An answer with an old ticket is ignored.
  void complete(std::uint32_t ticket, const DriveAnswer& answer, DriveTime now);

  /// @return the objects that TPDOs carry but the drive's status does not contain, each once. The
  ///         host reads them periodically and passes them to set_values(); those TPDOs are not sent
  ///         before. Changes only together with parameter_changes().
  [[nodiscard]] std::vector<ObjectAddress> read_objects() const;

  /// The drive's values of read_objects(). Sends nothing itself: the next SYNC or update() does.
  void set_values(std::span<const DriveValue> values);

  /// The drive has refused values of RPDOs. They are only counted: CiA 301 has no answer to a PDO.
  void note_refused_set_points(std::uint64_t count) noexcept;

  [[nodiscard]] std::uint8_t id() const noexcept;
  [[nodiscard]] NmtState state() const noexcept;
  [[nodiscard]] const NodeCounters& counters() const noexcept;

  /// The communication parameters last saved by 1010h:01 that differ from their defaults. They take
  /// effect at the next NMT reset, and at start().
  [[nodiscard]] const Parameters& stored() const noexcept;

  /// The current value of a communication object; none if it belongs to the drive or does not
  /// exist. For the ASCII gateway, tests and reports.
  [[nodiscard]] std::optional<std::int64_t> value(ObjectAddress object) const;

  /// @return how often communication parameters were written or reset. As long as it stays the
  ///         same, value() does too.
  [[nodiscard]] std::uint64_t parameter_changes() const noexcept;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::canopen
