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

/// What the PDOs of a node do to the node. Called within a call of Pdos; returns at once.
class PdoHost {
 public:
  virtual ~PdoHost() = default;

  virtual void send(const Frame& frame) = 0;

  /// As NodeHost::command(); the node passes it on, or counts the RPDOs while it does not own the
  /// axis.
  /// @param pdos that brought the values, 1 to kPdoCount
  virtual void command(std::span<const DriveValue> values, std::uint8_t pdos) = 0;

  /// An emergency of the communication, such as 8210h PDO not processed (CiA 301, table 26).
  virtual void raise(std::uint16_t error_code) = 0;
};

struct PdoCounters {
  /// RPDOs that were too short, or came outside of Operational, or, of a synchronous one, after the
  /// synchronous window (1007h)
  std::uint64_t dropped = 0;
};

/// How many RPDOs and how many TPDOs a node has.
inline constexpr std::uint8_t kPdoCount = 4;

/// The process data objects of a node (CiA 301, 7.2.2), with SYNC consumer and its counter: it has
/// the communication objects 1005h to 1007h, 1019h, 1400h.., 1600h.., 1800h.., 1A00h.., as they are
/// in force. For one thread.
///
/// At a SYNC the TPDOs go first, with the drive of the last update(); then all set-points that
/// synchronous RPDOs have brought since the SYNC before are passed by one PdoHost::command(): in
/// the order of the PDOs, each object once (of several values that of the last PDO), 6040h last.
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
  /// @pre has(object), and the object exists
  /// @return why it is refused, by the rules of CiA 301 for COB-IDs, mapping, transmission types;
  ///         none when it is in force.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// All objects have their defaults again; PDOs are stopped.
  void reset();

  /// PDOs are exchanged from now on; TPDOs on change are sent once with their present value.
  void start(const AxisStatus& drive, DriveTime now);

  /// RPDOs are dropped and counted, SYNC is ignored, nothing is sent. What waits is forgotten.
  void stop();

  /// A frame of the bus: SYNC, RPDOs of this node, and remote frames for TPDOs that allow them; all
  /// others are not for it.
  /// @return whether it was one of those.
  bool receive(const Frame& frame, DriveTime now);

  /// The drive after a tick, with 6041h as masters see it: what the next TPDOs carry.
  void update(const AxisStatus& drive, DriveTime now);

  /// @return the objects to read for TPDOs, as TransmitPdo::add_read_objects().
  [[nodiscard]] std::vector<ObjectAddress> read_objects() const;

  /// What the drive has for one of them: what the TPDOs of the next SYNC, update() or advance()
  /// carry.
  void set_value(const DriveValue& reading);

  /// Sends TPDOs whose inhibit time or event timer has elapsed; raises the time-outs of RPDOs.
  void advance(DriveTime now);

  /// @return whether an error of a receive PDO or of SYNC lasts, which PdoHost::raise() was told.
  [[nodiscard]] bool has_error() const noexcept;

  /// @return when advance() has something to do next, a time that has passed = at once; none =
  ///         nothing waits for time.
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
  SetPoints set_points_;               ///< of the call under way
  AxisStatus drive_{};
  PdoCounters counters_{};
  bool is_started_ = false;
};

}  // namespace vdrive::canopen
