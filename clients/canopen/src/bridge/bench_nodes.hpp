// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/listeners.hpp"
#include "bridge/node_store.hpp"
#include "bridge/set_point_batch.hpp"
#include "bus/bus.hpp"
#include "node/node.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::canopen {

/// An axis and its node.
struct NodePlace {
  std::uint16_t axis = 0;  ///< number on its bench
  std::uint8_t node_id = 0;
};

/// Adds the counters of further nodes.
void add_counters(NodeCounters& sum, const NodeCounters& more);

/// The requests of a bench's nodes to its drives; `place` is the position in the list of NodePlace.
/// They are made after all calls of nodes have returned, so each of these functions may call
/// BenchNodes::complete().
class NodeDrives {
 public:
  virtual ~NodeDrives() = default;

  virtual void access(std::size_t place, const DriveAccess& access) = 0;
  virtual void tell_connection(std::size_t place, bool is_lost) = 0;
  virtual void cycle_power(std::size_t place) = 0;

  /// The first set-point is ready for BenchNodes::take_set_points().
  virtual void note_set_points() = 0;

  /// Reads objects that TPDOs carry and the status does not contain. Answer with
  /// BenchNodes::take_values(), even if no value could be read: a node asks again only after it has
  /// its answer.
  virtual void read(std::size_t place, std::uint32_t ticket,
                    const std::vector<ObjectAddress>& objects) = 0;

  /// All nodes have received a SYNC: time advances by Options::sync_period.
  virtual void pass_sync() {}
};

/// The nodes of the axes of one bench, as a port of their bus: passes frames, states and drive time
/// to them, and their requests to NodeDrives. It has no access to the bench itself. For the thread
/// of the bus.
class BenchNodes final : public Port {
 public:
  struct Options {
    std::uint64_t session = 0;  ///< the session that controls the axes
    std::optional<std::uint32_t>
        sync_period{};                  ///< see NodeSettings; none = SYNC does not advance time
    const char* software_version = "";  ///< 100Ah
    /// Shortest drive time between two NodeDrives::read() of a node; after a new mapping it reads
    /// without waiting.
    DriveTime read_period{};
  };

  /// @param bus, store, drives outlive this object
  BenchNodes(Bus& bus, NodeStore& store, NodeDrives& drives, std::span<const NodePlace> places,
             const Options& options);
  ~BenchNodes() override;
  BenchNodes(const BenchNodes&) = delete;
  BenchNodes& operator=(const BenchNodes&) = delete;

  /// The drives are present: each node boots.
  /// @param drives one axis for each place, in the same order
  void start(std::span<const client::AxisSnapshot> drives, DriveTime now);

  /// The drives are gone: the nodes disappear without sending a frame.
  void stop();

  [[nodiscard]] bool is_running() const noexcept { return is_running_; }

  /// @return the drive time last passed to the nodes.
  [[nodiscard]] DriveTime now() const noexcept { return now_; }

  /// @return the drive time for faults of the bus: since the start of the bench if SYNC steps it,
  ///         otherwise since the first nodes joined the bus. (Real-time ticks count from 1970.)
  [[nodiscard]] DriveTime fault_time() const noexcept { return now_ - begin_; }

  /// The status of the drives after a tick.
  void update(std::span<const client::AxisSnapshot> drives, DriveTime now);

  /// The answer to NodeDrives::access(). Answers to requests made before the last start() are
  /// ignored.
  void complete(std::size_t place, std::uint32_t ticket, const DriveAnswer& answer);

  /// The answer to NodeDrives::read(): the values that could be read. They are sent at the next
  /// SYNC or update(). Answers to requests made before the last start() are ignored.
  void take_values(std::size_t place, std::uint32_t ticket, std::span<const DriveValue> values);

  /// The drive of the axis has refused values of RPDOs.
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count);

  [[nodiscard]] bool has_set_points() const noexcept { return !set_points_.is_empty(); }

  [[nodiscard]] std::vector<client::SetPointFrame> take_set_points();

  void deliver(const Frame& frame) override;

  /// @return the sums of the counters of all nodes since the construction of this object.
  [[nodiscard]] NodeCounters counters() const;

  /// @return the number of set-points that arrived faster than they could be handed over.
  [[nodiscard]] std::uint64_t replaced_set_points() const noexcept {
    return set_points_.replaced();
  }

  /// @return the node at a place, for tests and reports; nullptr while the drives are gone.
  [[nodiscard]] const Node* node(std::size_t place) const;

 private:
  class Slot;

  /// A frame of a node on its way to the bus.
  struct Outgoing {
    Frame frame;
    std::size_t place = 0;
    bool is_late = false;  ///< a fault of the bus has delayed it
  };

  /// A frame delayed by a fault of the bus.
  struct LateFrame {
    Frame frame;
    std::size_t place = 0;  ///< place of its node
    FrameDirection direction{};
  };

  /// A frame on the bus.
  struct Incoming {
    const Frame& frame;
    std::uint64_t number = 0;             ///< its number on the bus
    std::optional<std::size_t> sender{};  ///< place of the node that sent it; none = another port
  };

  void receive(const Incoming& incoming);
  void give(std::size_t place, const Incoming& incoming);
  void give_now(std::size_t place, const Frame& frame);
  [[nodiscard]] int copies_now(const FrameFate& fate, const LateFrame& frame);
  void follow_faults();
  void release_late_frames();
  void settle();
  void send(const Outgoing& outgoing);
  void send_now(const Outgoing& outgoing);
  void run_drive_calls();
  void note_changes(std::size_t place);
  void ask_for_new_values();
  void refresh_listeners();
  [[nodiscard]] bool is_sync(const Frame& frame) const;

  Bus& bus_;
  NodeStore& store_;
  NodeDrives& drives_;
  const Options options_;
  std::vector<std::unique_ptr<Slot>> slots_;
  DriveTime now_{};
  DriveTime begin_{};  ///< origin of fault_time()
  bool is_running_ = false;
  bool is_settling_ = false;
  bool are_noted_ = false;  ///< NodeDrives::note_set_points() was called for the waiting set-points
  Listeners listeners_;
  bool are_listeners_old_ = true;
  bool are_mappings_new_ = true;  ///< a node may have different objects to read
  // Filled during calls of nodes, carried out after them.
  std::vector<Outgoing> outgoing_;
  std::vector<Outgoing> sending_;  ///< swapped with `outgoing_` to reuse memory
  std::vector<std::function<void()>> drive_calls_;
  std::multimap<DriveTime, LateFrame> late_;  ///< by time of arrival, then in order of sending
  std::uint64_t sent_ = 0;                    ///< number of frames from nodes, for the faults of
                                              ///< the bus
  SetPointBatch set_points_;
  NodeCounters ended_;  ///< counters of nodes that are gone
};

}  // namespace vdrive::canopen
