// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"

#include <sys/types.h>

#include <chrono>
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

/// @return the frame for raw CAN sockets of the kernel.
[[nodiscard]] can_frame to_can_frame(const Frame& frame) noexcept;

/// @return the frame from a raw CAN socket; nothing for a controller error message and a frame of
///         more than 8 bytes.
[[nodiscard]] std::optional<Frame> from_can_frame(const can_frame& frame) noexcept;

/// The system calls of a port; tests replace them.
class CanSockets {
 public:
  virtual ~CanSockets() = default;

  /// @return a non-blocking socket.
  /// @throws std::runtime_error as SocketCan::SocketCan() does
  virtual int open(const std::string& interface) = 0;

  /// As read(2) and write(2) of one frame, including errno.
  virtual ssize_t read(int socket, can_frame& frame) = 0;
  virtual ssize_t write(int socket, const can_frame& frame) = 0;
};

/// @return the system calls of the kernel.
[[nodiscard]] CanSockets& kernel_can_sockets() noexcept;

struct SocketCanSettings {
  std::string interface;                   ///< such as "can0"
  std::size_t most_waiting_frames = 4096;  ///< queue size while the interface accepts none, at
                                           ///< least 1
  /// When the queue is full, the bus is held until half of it is sent, and no frame is lost.
  bool holds_bus = false;
  std::chrono::milliseconds reopen_period{1000};  ///< while no interface of this name exists
};

/// Counters of an interface since it was opened.
struct SocketCanCounters {
  std::uint64_t received_frames = 0;  ///< from the interface
  std::uint64_t sent_frames = 0;      ///< to the interface
  std::uint64_t dropped_frames = 0;   ///< the oldest in the queue, refused ones, and those to an
                                      ///< interface that is down or gone
  std::uint64_t errors = 0;           ///< read and write errors, for example while the interface is
                                      ///< down
};

/// A CAN interface of the kernel (SocketCAN, CAN_RAW) as a port of a bus: frames on the wire come
/// to the bus, and frames of the bus go to the wire and to other programs on the interface. Frames
/// to an interface that is down or gone are dropped, because late ones would move a drive. An
/// interface that was unplugged is reopened by its name. For the thread of its context.
class SocketCan final {
 public:
  /// @param context, bus, host, sockets outlive the object
  /// @throws std::runtime_error when the interface cannot be opened, with its name, the reason and
  ///         the next step; also when the kernel has no CAN support
  SocketCan(boost::asio::io_context& context, Bus& bus, BusHost& host, SocketCanSettings settings,
            CanSockets& sockets = kernel_can_sockets());
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  [[nodiscard]] const SocketCanCounters& counters() const noexcept;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared: pending operations of the context keep it alive
};

}  // namespace vdrive::canopen
