// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::canopen {

/// A connection of a bus: a client of the socketcand server, a CAN interface, the nodes, the ASCII
/// gateway. A port is called by the thread of the bus.
class Port {
 public:
  virtual ~Port() = default;

  /// A frame that another port has sent. What the port sends within it waits for its end.
  virtual void deliver(const Frame& frame) = 0;
};

/// A CAN bus: each frame that a port sends is delivered to every other port, in one order for all.
/// For one thread.
class Bus {
 public:
  void attach(Port& port);

  /// What is detached gets no further frame.
  void detach(Port& port);

  /// Delivers `frame` to all ports but `sender`. Frames that are sent during a delivery wait for
  /// its end.
  void send(const Frame& frame, const Port* sender);

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }  ///< since it was made

 private:
  struct Waiting {
    Frame frame;
    const Port* sender = nullptr;
  };

  std::vector<Port*> ports_;
  std::vector<Waiting> waiting_;
  std::uint64_t frames_ = 0;
  bool is_delivering_ = false;
};

}  // namespace vdrive::canopen
