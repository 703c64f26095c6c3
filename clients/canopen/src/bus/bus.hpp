// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus_faults.hpp"
#include "node/frame.hpp"
#include "severity.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

/// A connection of a bus: a client of the socketcand server, a CAN interface, the nodes, the ASCII
/// gateway. A port is called by the thread of the bus.
class Port {
 public:
  virtual ~Port() = default;

  /// A frame that another port has sent. What it sends within this call comes after the frame.
  virtual void deliver(const Frame& frame) = 0;

  /// The bus is not held any more (Bus::hold()): reads on. It puts nothing on the bus within this
  /// call.
  virtual void resume() {}
};

/// What the ports to the outside need of the program that has the bus. Called by the thread of the
/// bus.
class BusHost {
 public:
  virtual ~BusHost() = default;

  /// Takes what has happened to a port.
  /// @param port such as "interface can0"; empty = the bus itself
  /// @param text a sentence without a full stop
  virtual void report(bridge::Severity severity, const std::string& port,
                      const std::string& text) = 0;

  /// @return the time of a frame that is on the bus now, since any beginning.
  [[nodiscard]] virtual std::chrono::microseconds frame_time() const = 0;

  /// Begins a fault of the bus (parse_bus_fault()), or ends those that there are ("none").
  /// @param node 0 = every node
  /// @return why it cannot
  [[nodiscard]] virtual std::optional<std::string> disturb(std::uint8_t node,
                                                           std::string_view fault) = 0;
};

/// A CAN bus: each frame that a port sends is delivered to every other port, in one order for all.
/// For one thread.
class Bus {
 public:
  /// Frames that one frame may bring about. Some thousand are those of a bus with 127 nodes; nodes
  /// that answer each other without an end, such as two whose PDOs are the SYNC of the other one,
  /// would keep the thread for ever.
  static constexpr std::size_t kMostAtOnce = 8'192;

  void attach(Port& port);

  /// What is detached gets no further frame, and does not hold the bus any more.
  void detach(Port& port);

  /// Delivers `frame` to all ports but `sender`. Frames that are sent during a delivery wait for
  /// its end; those beyond kMostAtOnce are dropped.
  /// @return its number: frames() while it is delivered; 0 = it is dropped
  std::uint64_t send(const Frame& frame, const Port* sender);

  /// Back pressure, where time stands until a frame comes: a port whose clients have no room for
  /// more frames holds the bus. While it is held no port reads from outside.
  void hold(const Port& port);

  /// `port` can take frames again. When no other one holds the bus all ports resume.
  void release(const Port& port);

  [[nodiscard]] bool is_held() const noexcept { return !holders_.empty(); }

  /// Counts frames that their port has dropped for kMostAtOnce itself.
  void note_dropped(std::size_t frames) noexcept { dropped_frames_ += frames; }

  /// What is wrong between its nodes and it: the ports of nodes apply it.
  [[nodiscard]] BusFaults& faults() noexcept { return faults_; }

  [[nodiscard]] const BusFaults& faults() const noexcept { return faults_; }

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }  ///< since it was made

  /// @return frames beyond kMostAtOnce, since it was made.
  [[nodiscard]] std::uint64_t dropped_frames() const noexcept { return dropped_frames_; }

 private:
  struct Waiting {
    Frame frame;
    const Port* sender = nullptr;
  };

  void deliver_waiting();

  std::vector<Port*> ports_;
  std::vector<const Port*> holders_;  ///< each once
  std::vector<Waiting> waiting_;
  BusFaults faults_;
  std::uint64_t frames_ = 0;
  std::uint64_t sent_ = 0;  ///< that wait, too
  std::uint64_t dropped_frames_ = 0;
  bool is_delivering_ = false;
};

}  // namespace vdrive::canopen
