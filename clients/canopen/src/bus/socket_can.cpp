// SPDX-License-Identifier: Apache-2.0
#include "bus/socket_can.hpp"

#include "bus/asio.hpp"
#include "bus/waiting_frames.hpp"
#include "vdrive/text.hpp"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace vdrive::canopen {
namespace {

// At 1 Mbit/s, a transmit queue of 10 frames (the kernel's default) is sent in 1 ms.
constexpr std::chrono::milliseconds kFullQueuePause{1};
// Pause after an error: while an interface fails, every operation fails immediately.
constexpr std::chrono::milliseconds kCanErrorPause{100};
// Frames read before others get their turn.
constexpr int kMostFramesAtOnce = 64;

/// Closes a socket that has no owner yet.
class OpenCanSocket final {
 public:
  explicit OpenCanSocket(int descriptor) noexcept : descriptor_(descriptor) {}

  ~OpenCanSocket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  OpenCanSocket(const OpenCanSocket&) = delete;
  OpenCanSocket& operator=(const OpenCanSocket&) = delete;

  [[nodiscard]] int get() const noexcept { return descriptor_; }

  [[nodiscard]] int release() noexcept { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_;
};

[[noreturn]] void throw_unopened(const std::string& interface, const std::string& reason) {
  throw std::runtime_error("cannot open CAN interface " + in_quotes(interface) + ": " + reason);
}

std::string can_error_words(int error) {
  return std::system_category().message(error);
}

int open_raw_socket(const std::string& interface) {
  OpenCanSocket raw(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (raw.get() < 0) {
    const int error = errno;
    const bool is_missing = error == EAFNOSUPPORT || error == EPROTONOSUPPORT;
    throw_unopened(interface, is_missing ? "this kernel has no CAN (module can_raw); serve the bus "
                                           "with --socketcand 127.0.0.1:29536 instead"
                                         : can_error_words(error));
  }
  const unsigned index = interface.size() < IFNAMSIZ ? ::if_nametoindex(interface.c_str()) : 0;
  if (index == 0) {
    throw_unopened(interface,
                   "there is no network interface of this name; 'ip link' lists them, "
                   "and --socketcand 127.0.0.1:29536 serves the bus without one");
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): how the socket API takes addresses
  if (::bind(raw.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int error = errno;
    throw_unopened(interface,
                   error == ENODEV ? "it is not a CAN interface" : can_error_words(error));
  }
  return raw.release();
}

class KernelCanSockets final : public CanSockets {
 public:
  int open(const std::string& interface) override { return open_raw_socket(interface); }

  ssize_t read(int socket, can_frame& frame) override {
    return ::read(socket, &frame, sizeof frame);
  }

  ssize_t write(int socket, const can_frame& frame) override {
    return ::write(socket, &frame, sizeof frame);
  }
};

/// The interface was removed: a reader gets ENODEV once, each writer ENXIO.
bool means_gone(int error) {
  return error == ENODEV || error == ENXIO;
}

}  // namespace

CanSockets& kernel_can_sockets() noexcept {
  static KernelCanSockets sockets;
  return sockets;
}

can_frame to_can_frame(const Frame& frame) noexcept {
  can_frame converted{};
  converted.can_id = frame.id;
  if (frame.is_extended) converted.can_id |= CAN_EFF_FLAG;
  if (frame.is_remote) converted.can_id |= CAN_RTR_FLAG;
  converted.can_dlc = frame.size;  // NOLINT(cppcoreguidelines-pro-type-union-access): kernel ABI
  std::ranges::copy(frame.bytes(), std::begin(converted.data));
  return converted;
}

std::optional<Frame> from_can_frame(const can_frame& frame) noexcept {
  const std::uint8_t size = frame.can_dlc;  // NOLINT(cppcoreguidelines-pro-type-union-access): same
  if ((frame.can_id & CAN_ERR_FLAG) != 0 || size > kMostData) return std::nullopt;
  Frame converted;
  converted.is_extended = (frame.can_id & CAN_EFF_FLAG) != 0;
  converted.is_remote = (frame.can_id & CAN_RTR_FLAG) != 0;
  converted.id = frame.can_id & (converted.is_extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  converted.size = size;
  std::copy_n(std::begin(frame.data), converted.bytes().size(), converted.data.begin());
  return converted;
}

struct SocketCan::State final : Port, std::enable_shared_from_this<SocketCan::State> {
  State(asio::io_context& context, Bus& its_bus, BusHost& its_host,
        SocketCanSettings&& its_settings, CanSockets& its_sockets)
      : bus(its_bus),
        host(its_host),
        sockets(its_sockets),
        settings(std::move(its_settings)),
        socket(context, sockets.open(settings.interface)),
        read_pause(context),
        write_pause(context),
        reopen_pause(context),
        waiting(context.get_executor(), bus, *this, settings.most_waiting_frames,
                settings.holds_bus) {}

  ~State() override = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void start() {
    bus.attach(*this);
    await_readable();
  }

  void stop() {
    if (std::exchange(is_over, true)) return;
    waiting.clear();
    bus.detach(*this);
    cancel(reopen_pause);
    close();
  }

  /// Pending operations of the socket belong to a previous opening from now on.
  void close() {
    ++opening;
    cancel(read_pause);
    cancel(write_pause);
    is_awaiting_write = false;
    is_read_put_off = false;
    AsioError ignored;
    socket.close(ignored);
  }

  [[nodiscard]] bool is_current(std::uint64_t its_opening) const noexcept {
    return !is_over && its_opening == opening;
  }

  void deliver(const Frame& frame) override {
    if (!socket.is_open()) {
      ++counters.dropped_frames;
      return;
    }
    if (!waiting.put({.frame = frame}, *this)) ++counters.dropped_frames;
    if (!is_awaiting_write) write_waiting();
  }

  void resume() override {
    if (!std::exchange(is_read_put_off, false)) return;
    asio::post(socket.get_executor(), [self = shared_from_this(), its_opening = opening] {
      if (self->is_current(its_opening)) self->read();
    });
  }

  void await_readable() {
    socket.async_wait(asio::posix::stream_descriptor::wait_read,
                      [self = shared_from_this(), its_opening = opening](const AsioError& error) {
                        if (self->is_current(its_opening) && !error) self->read();
                      });
  }

  void read() {
    const std::uint64_t its_opening = opening;
    for (int frames = 0; frames < kMostFramesAtOnce; ++frames) {
      if (bus.is_held()) {
        is_read_put_off = true;
        return;
      }
      can_frame received{};
      const ssize_t size = sockets.read(socket.native_handle(), received);
      if (size < 0) return on_read_error(errno);
      note_up();
      if (size != static_cast<ssize_t>(sizeof received)) continue;
      if (const auto frame = from_can_frame(received)) {
        ++counters.received_frames;
        bus.send(*frame, this);
        // The call above may have written answers to the frame, and found that the interface is
        // gone.
        if (!is_current(its_opening)) return;
      }
    }
    await_readable();
  }

  void on_read_error(int error) {
    if (error == EAGAIN || error == EINTR) return await_readable();
    ++counters.errors;
    if (means_gone(error)) return lose();
    if (error == ENETDOWN) {
      note_down();
    } else {
      report(bridge::Severity::warning, "cannot be read: " + can_error_words(error));
    }
    read_pause.expires_after(kCanErrorPause);
    read_pause.async_wait(
        [self = shared_from_this(), its_opening = opening](const AsioError& timer_error) {
          if (self->is_current(its_opening) && !timer_error) self->read();
        });
  }

  void write_waiting() {
    while (!waiting.empty()) {
      const can_frame frame = to_can_frame(waiting.front().frame);
      const ssize_t size = sockets.write(socket.native_handle(), frame);
      if (size < 0) return on_write_error(errno);
      ++counters.sent_frames;
      waiting.pop();
      note_up();
    }
  }

  void on_write_error(int error) {
    // ENOBUFS: the queue of the interface is full, but poll() would call the socket writable.
    if (error == ENOBUFS || error == EAGAIN || error == EINTR) return write_after(kFullQueuePause);
    ++counters.errors;
    if (means_gone(error)) return lose();
    if (error == ENETDOWN) return note_down();  // the next frame tries again
    report(bridge::Severity::warning, "refuses a frame: " + can_error_words(error));
    ++counters.dropped_frames;
    waiting.pop();
    write_after(kCanErrorPause);
  }

  void write_after(std::chrono::milliseconds pause) {
    is_awaiting_write = true;
    write_pause.expires_after(pause);
    write_pause.async_wait(
        [self = shared_from_this(), its_opening = opening](const AsioError& error) {
          if (!self->is_current(its_opening)) return;
          self->is_awaiting_write = false;
          if (!error) self->write_waiting();
        });
  }

  // ---- state of the interface

  void report(bridge::Severity severity, const std::string& text) const {
    host.report(severity, "interface " + settings.interface, text);
  }

  void drop_waiting() {
    counters.dropped_frames += waiting.size();
    waiting.clear();
  }

  /// See WaitingFrames::put().
  void report_hold() const {
    if (is_over) return;
    report(bridge::Severity::warning,
           "is not sending: " + std::to_string(waiting.size()) +
               " frames are queued for it; bus and drive time stand still until it sends or goes "
               "down; 'ip -details link show " +
               settings.interface + "' shows its state");
  }

  void note_down() {
    drop_waiting();
    if (std::exchange(is_down, true)) return;
    report(bridge::Severity::warning, "is down: frames are dropped until it is up; 'ip link set " +
                                          settings.interface + " up' does that");
  }

  void note_up() {
    if (!std::exchange(is_down, false)) return;
    report(bridge::Severity::info, "is up");
  }

  void lose() {
    drop_waiting();
    close();
    is_down = false;
    report(bridge::Severity::warning,
           "is gone: frames are dropped until there is an interface of this name again");
    reopen_later();
  }

  void reopen_later() {
    reopen_pause.expires_after(settings.reopen_period);
    reopen_pause.async_wait([self = shared_from_this()](const AsioError& error) {
      if (!self->is_over && !error) self->reopen();
    });
  }

  void reopen() {
    try {
      socket.assign(sockets.open(settings.interface));
    } catch (const std::runtime_error&) {  // reported when it was lost
      return reopen_later();
    }
    report(bridge::Severity::info, "is open again");
    await_readable();
  }

  Bus& bus;
  BusHost& host;
  CanSockets& sockets;
  const SocketCanSettings settings;
  asio::posix::stream_descriptor socket;
  asio::steady_timer read_pause;
  asio::steady_timer write_pause;
  asio::steady_timer reopen_pause;
  WaitingFrames waiting;
  SocketCanCounters counters;
  std::uint64_t opening = 0;  ///< counts the openings of the socket
  bool is_awaiting_write = false;
  bool is_read_put_off = false;  ///< because the bus was held
  bool is_down = false;
  bool is_over = false;
};

SocketCan::SocketCan(boost::asio::io_context& context, Bus& bus, BusHost& host,
                     SocketCanSettings settings, CanSockets& sockets)
    : state_(std::make_shared<State>(context, bus, host, std::move(settings), sockets)) {
  state_->start();
}

SocketCan::~SocketCan() {
  state_->stop();
}

const SocketCanCounters& SocketCan::counters() const noexcept {
  return state_->counters;
}

}  // namespace vdrive::canopen
