// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

struct can_frame;  // of <linux/can.h>

namespace boost::asio {
class io_context;
}

namespace vdrive::canopen {

/// @return the frame as the kernel's raw CAN sockets take it.
[[nodiscard]] can_frame to_can_frame(const Frame& frame) noexcept;

/// @return the frame that a raw CAN socket gave; nothing for an error message of the controller,
/// and
///         for one of more than 8 bytes.
[[nodiscard]] std::optional<Frame> from_can_frame(const can_frame& frame) noexcept;

struct SocketCanSettings {
  std::string interface;                   ///< such as "can0"
  std::size_t most_waiting_frames = 4096;  ///< while the interface takes none, at least 1
};

/// What an interface counts since it was opened.
struct SocketCanCounters {
  std::uint64_t received_frames = 0;  ///< from the interface
  std::uint64_t sent_frames = 0;      ///< to the interface
  std::uint64_t dropped_frames = 0;   ///< the oldest that waited, and those that were refused
  std::uint64_t errors = 0;           ///< of reading and writing, such as an interface that is down
};

/// A CAN interface of the kernel (SocketCAN, CAN_RAW) as a port of a bus: frames of others on the
/// wire come to the bus, frames of the bus go to the wire and to other programs on the interface.
/// It tries again while the interface is down. For the thread of its context.
class SocketCan final {
 public:
  /// @param context, bus outlive the object
  /// @throws std::runtime_error when the interface cannot be opened, with its name, the reason and
  ///         the next step; a kernel without CAN is one
  SocketCan(boost::asio::io_context& context, Bus& bus, SocketCanSettings settings);
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  [[nodiscard]] const SocketCanCounters& counters() const noexcept;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< an operation of the context that ends later keeps it
};

}  // namespace vdrive::canopen
