// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/receive_pdo.hpp"
#include "node/sync_consumer.hpp"
#include "node/transmit_pdo.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::canopen {

/// The callbacks of Pdos, implemented by its node. They are called within a call of Pdos and must
/// not block.
class PdoHost {
 public:
  virtual ~PdoHost() = default;

  virtual void send(const Frame& frame) = 0;

  /// As NodeHost::command(). The node passes the values on, or only counts the RPDOs while the
  /// bridge does not own the axis.
  /// @param pdos number of RPDOs that contributed values, 1 to kPdoCount
  virtual void command(std::span<const DriveValue> values, std::uint8_t pdos) = 0;

  /// A communication error, such as 8210h PDO not processed (CiA 301, table 26).
  virtual void raise(std::uint16_t error_code) = 0;
};

struct PdoCounters {
  /// RPDOs that were too short, arrived outside of Operational, or (synchronous ones) arrived after
  /// the synchronous window (1007h)
  std::uint64_t dropped = 0;
};

/// The number of RPDOs, and of TPDOs, of a node.
inline constexpr std::uint8_t kPdoCount = 4;

/// The process data objects of a node (CiA 301, 7.2.2), with its SYNC consumer and SYNC counter.
/// Holds the communication objects 1005h to 1007h, 1019h, 1400h.., 1600h.., 1800h.. and 1A00h.. in
/// force. For one thread.
///
/// At a SYNC the TPDOs are sent first, with the drive of the last update(). Then one
/// PdoHost::command() passes all set-points that synchronous RPDOs have brought since the previous
/// SYNC: in the order of the PDOs, each object once (with the value of the last PDO), 6040h last.
class Pdos {
 public:
  /// All objects get their defaults of node_objects().
  /// @param host outlives the PDOs
  /// @param sync_period that 1006h accepts besides 0 [us]; none = any
  Pdos(std::uint8_t node_id, PdoHost& host, std::optional<std::uint32_t> sync_period);

  /// @return whether `object` is one that Pdos holds.
  [[nodiscard]] static bool has(ObjectAddress object) noexcept;

  /// @pre has(object), and the object exists
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const;

  /// Access and length have already been checked.
  /// @pre has(object), and the object exists
  /// @return why the value is refused, by the rules of CiA 301 for COB-IDs, mappings and
  ///         transmission types; none if it is in force.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// Sets all objects back to their defaults and stops the PDOs.
  void reset();

  /// Begins to exchange PDOs; change-driven TPDOs are sent once with their present values.
  void start(const AxisStatus& drive, DriveTime now);

  /// From now on RPDOs are dropped and counted, SYNC is ignored, and nothing is sent. Anything
  /// pending is forgotten.
  void stop();

  /// A frame of the bus. Handles SYNC, RPDOs of this node, and remote frames for TPDOs that allow
  /// them.
  /// @return whether it was one of those.
  bool receive(const Frame& frame, DriveTime now);

  /// The status of the drive after a tick, with 6041h as masters see it; the next TPDOs carry it.
  void update(const AxisStatus& drive, DriveTime now);

  /// @return the objects to read for TPDOs, see TransmitPdo::add_read_objects().
  [[nodiscard]] std::vector<ObjectAddress> read_objects() const;

  /// The drive's value of an object of read_objects(), for the TPDOs of the next SYNC, update() or
  /// advance().
  void set_value(const DriveValue& reading);

  /// Sends TPDOs whose inhibit time or event timer has elapsed; raises RPDO time-outs.
  void advance(DriveTime now);

  /// @return whether an RPDO or SYNC error passed to PdoHost::raise() still lasts.
  [[nodiscard]] bool has_error() const noexcept;

  /// @return when advance() is next due, in the past = immediately; none = no timer is running.
  [[nodiscard]] std::optional<DriveTime> next_due() const;

  [[nodiscard]] const PdoCounters& counters() const noexcept { return counters_; }

 private:
  void restart();
  void synchronise(const Frame& sync, DriveTime now);
  bool answer(const Frame& request, DriveTime now);
  void take(ReceivePdo& pdo, const Frame& frame, DriveTime now);
  void send_due(DriveTime now);
  void send(const std::optional<Frame>& frame);
  void raise(std::uint16_t error_code);
  void command(std::uint8_t pdos);

  PdoHost& host_;
  SyncConsumer sync_;
  std::vector<ReceivePdo> receive_;    ///< kPdoCount
  std::vector<TransmitPdo> transmit_;  ///< kPdoCount
  SetPoints set_points_;               ///< of the current call
  AxisStatus drive_{};
  PdoCounters counters_{};
  bool is_started_ = false;
};

}  // namespace vdrive::canopen
