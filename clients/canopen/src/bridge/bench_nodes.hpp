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

/// An axis and the node that it is.
struct NodePlace {
  std::uint16_t axis = 0;  ///< number on its bench
  std::uint8_t node_id = 0;
};

/// Adds what more nodes have counted.
void add_counters(NodeCounters& sum, const NodeCounters& more);

/// What the nodes of a bench ask of its drives; `place` is that of NodePlace. No call of a node is
/// under way then, so that BenchNodes::complete() may be called at once.
class NodeDrives {
 public:
  virtual ~NodeDrives() = default;

  virtual void access(std::size_t place, const DriveAccess& access) = 0;
  virtual void tell_connection(std::size_t place, bool is_lost) = 0;
  virtual void cycle_power(std::size_t place) = 0;

  /// The first set-point waits for BenchNodes::take_set_points().
  virtual void note_set_points() = 0;

  /// Reads objects that TPDOs carry and the status does not have; BenchNodes::take_values() is the
  /// answer, also with none of them. A node asks again when it has its answer, not before.
  virtual void read(std::size_t place, std::uint32_t ticket,
                    const std::vector<ObjectAddress>& objects) = 0;

  /// All nodes have received SYNC, whose period they were given.
  virtual void pass_sync() {}
};

/// The nodes of the axes of one bench, as a port of their bus: gives them frames, states and drive
/// time, and takes what they ask for. It knows no bench, only NodeDrives. For the thread of the
/// bus.
class BenchNodes final : public Port {
 public:
  struct Options {
    std::uint64_t session = 0;  ///< that controls the axes
    std::optional<std::uint32_t>
        sync_period{};                  ///< see NodeSettings; none = SYNC lets no time pass
    const char* software_version = "";  ///< 100Ah
    /// Drive time between two NodeDrives::read of a node at least; a new mapping waits for none.
    DriveTime read_period{};
  };

  /// @param bus, store, drives outlive this
  BenchNodes(Bus& bus, NodeStore& store, NodeDrives& drives, std::span<const NodePlace> places,
             const Options& options);
  ~BenchNodes() override;
  BenchNodes(const BenchNodes&) = delete;
  BenchNodes& operator=(const BenchNodes&) = delete;

  /// The drives are there: each node boots.
  /// @param drives one axis for each place, in their order
  void start(std::span<const client::AxisSnapshot> drives, DriveTime now);

  /// The drives are gone: the nodes vanish, without a frame.
  void stop();

  [[nodiscard]] bool is_running() const noexcept { return is_running_; }

  /// @return the drive time that the nodes were told last.
  [[nodiscard]] DriveTime now() const noexcept { return now_; }

  /// @return drive time as the faults of the bus count it: since the bench began where SYNC steps
  ///         it, else since the first nodes came to the bus. Ticks of real time count from 1970.
  [[nodiscard]] DriveTime fault_time() const noexcept { return now_ - begin_; }

  /// The drives after a tick.
  void update(std::span<const client::AxisSnapshot> drives, DriveTime now);

  /// The answer to NodeDrives::access. An answer from before the last start() is ignored.
  void complete(std::size_t place, std::uint32_t ticket, const DriveAnswer& answer);

  /// The answer to NodeDrives::read: the values that could be read. They go out with the next SYNC,
  /// or the next update(). Values asked for before the last start() are ignored.
  void take_values(std::size_t place, std::uint32_t ticket, std::span<const DriveValue> values);

  /// The drive of the axis has refused values of RPDOs.
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count);

  [[nodiscard]] bool has_set_points() const noexcept { return !set_points_.is_empty(); }

  [[nodiscard]] std::vector<client::SetPointFrame> take_set_points();

  void deliver(const Frame& frame) override;

  /// @return what all nodes have counted since this was made.
  [[nodiscard]] NodeCounters counters() const;

  /// @return set-points that came faster than they could be handed over.
  [[nodiscard]] std::uint64_t replaced_set_points() const noexcept {
    return set_points_.replaced();
  }

  /// @return the node at a place, for tests and reports; nothing while the drives are gone.
  [[nodiscard]] const Node* node(std::size_t place) const;

 private:
  class Slot;

  /// A frame of a node on its way to the bus.
  struct Outgoing {
    Frame frame;
    std::size_t place = 0;
    bool is_late = false;  ///< a fault of the bus has kept it until now
  };

  /// A frame that a fault of the bus keeps.
  struct LateFrame {
    Frame frame;
    std::size_t place = 0;  ///< of its node
    FrameDirection direction{};
  };

  /// A frame on the bus.
  struct Incoming {
    const Frame& frame;
    std::uint64_t number = 0;  ///< on the bus
    std::optional<std::size_t>
        sender{};  ///< the place of the node that has sent it; none = another port
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
  DriveTime begin_{};  ///< of fault_time()
  bool is_running_ = false;
  bool is_settling_ = false;
  bool are_noted_ = false;  ///< NodeDrives::note_set_points() was called for what waits
  Listeners listeners_;
  bool are_listeners_old_ = true;
  bool are_mappings_new_ = true;  ///< a node may have other objects to read
  // Filled within calls of nodes, carried out after them.
  std::vector<Outgoing> outgoing_;
  std::vector<Outgoing> sending_;  ///< its memory, used in turn
  std::vector<std::function<void()>> drive_calls_;
  std::multimap<DriveTime, LateFrame> late_;  ///< by the time of their arrival, then as they came
  std::uint64_t sent_ = 0;                    ///< frames of nodes, for the faults of the bus
  SetPointBatch set_points_;
  NodeCounters ended_;  ///< of nodes that are gone
};

}  // namespace vdrive::canopen
