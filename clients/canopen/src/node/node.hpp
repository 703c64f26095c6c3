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

/// What a node counts since it was made; a NMT reset leaves the counters.
struct NodeCounters {
  std::uint64_t ignored_set_points = 0;  ///< RPDOs that would have acted while another session owns
                                         ///< the axis: each that acts at once, and of each
                                         ///< synchronous one the last before a SYNC
  std::uint64_t refused_set_points = 0;  ///< values of RPDOs that the drive refused
  std::uint64_t dropped_pdos = 0;        ///< as PdoCounters::dropped
  std::uint64_t sdo_aborts = 0;          ///< that the node sent
  std::uint64_t sdo_time_outs = 0;       ///< transfers that the client did not continue
  std::uint64_t ignored_frames = 0;      ///< malformed frames with an identifier of this node, or
                                         ///< of NMT
  std::uint64_t held_back_emergencies = 0;  ///< by the inhibit time 1015h, until they were left out
};

/// A CANopen node (CiA 301) of one axis (CiA 402): a function of frames, states and time. It opens
/// nothing, waits for nothing, and reads no clock. For one thread.
///
/// Order of a tick at SYNC n: receive(SYNC) sends the TPDOs of what was sampled last (the drive at
/// n), and passes the RPDOs that came before it to NodeHost::command(), so that they act after n.
class Node {
 public:
  /// Its communication parameters at power-up; see stored().
  using Parameters = std::map<ObjectAddress, std::uint32_t>;

  /// @param settings their texts are copied
  /// @param host outlives the node
  /// @param stored communication parameters that 1010h:01 saved; empty = defaults. What is no
  ///        communication parameter is left out.
  Node(const NodeSettings& settings, NodeHost& host, Parameters stored = {});
  ~Node();
  Node(Node&&) noexcept;
  Node& operator=(Node&&) noexcept;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// The drive is there: boot-up, then pre-operational. Also when it is there again: an access that
  /// was under way is forgotten, and `now` may be an earlier time.
  void start(const DriveView& drive, DriveTime now);

  /// A frame of the bus, of whatever node; its own are ignored.
  void receive(const Frame& frame, DriveTime now);

  /// The drive after a new tick: emergencies, and PDOs that are sent on change.
  void update(const DriveView& drive, DriveTime now);

  /// Does what is due by time: heartbeat, its consumer, inhibit times, event timers, SDO time-outs.
  void advance(DriveTime now);

  /// The controller of the node has switched itself off the bus, or is back on it: an error of the
  /// communication (1029h:01, 6007h), and its end with the emergency 8140h. What the node sends
  /// between the two is the host's to drop.
  void set_bus_off(bool is_off, DriveTime now);

  /// @return when advance() has something to do next; none = nothing waits for time.
  [[nodiscard]] std::optional<DriveTime> next_due() const;

  /// The answer to NodeHost::begin_access(). One with an old ticket is ignored.
  void complete(std::uint32_t ticket, const DriveAnswer& answer, DriveTime now);

  /// @return objects that TPDOs carry and the status of the drive does not have, each once. The
  ///         host reads them and passes them to set_values(), again and again; until then those
  ///         TPDOs are not sent. It changes with parameter_changes() only.
  [[nodiscard]] std::vector<ObjectAddress> read_objects() const;

  /// What the drive has for them. It sends nothing: SYNC, or the next update(), does.
  void set_values(std::span<const DriveValue> values);

  /// The drive has refused values of RPDOs: they are counted. CiA 301 has no answer to a PDO.
  void note_refused_set_points(std::uint64_t count) noexcept;

  [[nodiscard]] std::uint8_t id() const noexcept;
  [[nodiscard]] NmtState state() const noexcept;
  [[nodiscard]] const NodeCounters& counters() const noexcept;

  /// Communication parameters as 1010h:01 saved them last, those that differ from their default.
  /// They are in force after the next NMT reset, and at start().
  [[nodiscard]] const Parameters& stored() const noexcept;

  /// The value of a communication object now; none where it is the drive's, or does not exist. For
  /// the ASCII gateway, tests and reports.
  [[nodiscard]] std::optional<std::int64_t> value(ObjectAddress object) const;

  /// @return how often communication parameters were written or reset. While it stays the same,
  ///         value() stays the same.
  [[nodiscard]] std::uint64_t parameter_changes() const noexcept;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::canopen
