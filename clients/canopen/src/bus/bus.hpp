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

/// A connection to the bus: a client of the socketcand server, a CAN interface, the nodes, the
/// ASCII gateway. Called by the thread of the bus.
class Port {
 public:
  virtual ~Port() = default;

  /// Delivers a frame that another port has sent. Frames sent within this call follow it on the
  /// bus.
  virtual void deliver(const Frame& frame) = 0;

  /// The bus is no longer held (Bus::hold()): the port reads again. It must not send within this
  /// call.
  virtual void resume() {}
};

/// Services of the bus's owner for its ports. Called by the thread of the bus.
class BusHost {
 public:
  virtual ~BusHost() = default;

  /// Reports an event of a port.
  /// @param port such as "interface can0"; empty = the bus itself
  /// @param text a sentence without a full stop
  virtual void report(bridge::Severity severity, const std::string& port,
                      const std::string& text) = 0;

  /// @return the time stamp for a frame that is on the bus now, from an arbitrary origin.
  [[nodiscard]] virtual std::chrono::microseconds frame_time() const = 0;

  /// Starts a fault of the bus (parse_bus_fault()), or ends all present ones ("none").
  /// @param node 0 = every node
  /// @return why it cannot
  [[nodiscard]] virtual std::optional<std::string> disturb(std::uint8_t node,
                                                           std::string_view fault) = 0;
};

/// A CAN bus: each frame from one port is delivered to every other port, in the same order for all.
/// For one thread.
class Bus {
 public:
  /// The most frames that one frame may cause. A bus with 127 nodes needs some thousand. Without a
  /// limit, nodes that answer each other endlessly, such as two whose PDOs are each other's SYNC,
  /// would block the thread for ever.
  static constexpr std::size_t kMostAtOnce = 8'192;

  void attach(Port& port);

  /// A detached port gets no further frames, and no longer holds the bus.
  void detach(Port& port);

  /// Delivers `frame` to all ports except `sender`. Frames sent during a delivery wait for its end;
  /// those beyond kMostAtOnce are dropped.
  /// @return the number of the frame, which frames() returns during its delivery; 0 = dropped
  std::uint64_t send(const Frame& frame, const Port* sender);

  /// Back pressure, for a bus whose drive time waits for SYNC: a port whose peer has no room for
  /// more frames holds the bus. While the bus is held, no port reads from outside.
  void hold(const Port& port);

  /// `port` can take frames again. Once no port holds the bus, all ports resume.
  void release(const Port& port);

  [[nodiscard]] bool is_held() const noexcept { return !holders_.empty(); }

  /// Counts frames that a port has dropped itself because of kMostAtOnce.
  void note_dropped(std::size_t frames) noexcept { dropped_frames_ += frames; }

  /// The faults between the bus and its nodes; the ports of the nodes apply them.
  [[nodiscard]] BusFaults& faults() noexcept { return faults_; }

  [[nodiscard]] const BusFaults& faults() const noexcept { return faults_; }

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }  ///< since construction

  /// @return the number of frames dropped because of kMostAtOnce, since construction.
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
  std::uint64_t sent_ = 0;  ///< includes waiting frames
  std::uint64_t dropped_frames_ = 0;
  bool is_delivering_ = false;
};

}  // namespace vdrive::canopen
