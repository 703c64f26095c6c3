// SPDX-License-Identifier: Apache-2.0
#pragma once

// CONTRACT of the class; the private part is the author's.
#include "node/drive_time.hpp"
#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::canopen {

/// What the PDOs of a node do to the node. Called within a call of Pdos; returns at once.
class PdoHost {
 public:
  virtual ~PdoHost() = default;
  virtual void send(const Frame& frame) = 0;
  /// As NodeHost::command(); the node passes it on, or counts it while it does not own the axis.
  virtual void command(std::span<const DriveValue> values) = 0;
  /// An emergency of the communication, such as 8210h PDO not processed (CiA 301, table 26).
  virtual void raise(std::uint16_t error_code) = 0;
};

struct PdoCounters {
  std::uint64_t dropped = 0;  ///< RPDOs that were too short, or came outside of Operational
};

/// The process data objects of a node (CiA 301, 7.2.2), with SYNC consumer and its counter: it has
/// the communication objects 1005h to 1007h, 1019h, 1400h.., 1600h.., 1800h.., 1A00h.., as they are
/// in force. For one thread.
class Pdos {
 public:
  /// All objects have their defaults of node_objects().
  /// @param host outlives the PDOs
  /// @param sync_period what 1006h may be besides 0 [us]; none = any
  Pdos(std::uint8_t node_id, PdoHost& host, std::optional<std::uint32_t> sync_period);

  /// @return whether `object` is one of these.
  [[nodiscard]] static bool has(ObjectAddress object) noexcept;

  /// @pre has(object), and the object exists
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const;

  /// Access and length have been judged.
  /// @return why it is refused, by the rules of CiA 301 for COB-IDs, mapping, transmission types;
  ///         none when it is in force.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// All objects have their defaults again.
  void reset();

  /// PDOs are exchanged from now on; TPDOs on change are sent once with their present value.
  void start(const AxisStatus& drive, DriveTime now);
  void stop();

  /// A frame of the bus: SYNC and RPDOs of this node; all others are not for it.
  /// @return whether it was one of those.
  bool receive(const Frame& frame, DriveTime now);

  /// The drive after a tick, with 6041h as masters see it: what the next TPDOs carry.
  void update(const AxisStatus& drive, DriveTime now);

  void advance(DriveTime now);
  [[nodiscard]] std::optional<DriveTime> next_due() const;
  [[nodiscard]] const PdoCounters& counters() const noexcept;
};

}  // namespace vdrive::canopen
