// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/asio.hpp"
#include "bus/bus.hpp"

#include <chrono>
#include <cstddef>
#include <deque>
#include <utility>

namespace vdrive::canopen {

/// A queued frame.
struct WaitingFrame {
  Frame frame;
  std::chrono::microseconds time{};  ///< BusHost::frame_time() when it was on the bus
};

/// The queue of frames for a port's peer (a client or an interface), which may be slow. When it is
/// full, either the oldest frame is dropped, or the port holds the bus (Bus::hold()) until the
/// queue is half empty, and no frame is lost. For the thread of the bus.
class WaitingFrames final {
 public:
  /// A hold of this length [wall time] is reported: to the user the bus looks dead.
  static constexpr std::chrono::milliseconds kLongHold{1000};

  /// @param most at least 1
  WaitingFrames(const asio::any_io_executor& executor, Bus& bus, const Port& port, std::size_t most,
                bool holds_bus)
      : timer_(executor), bus_(bus), port_(port), most_(most), holds_bus_(holds_bus) {}

  /// @param owner the port; its report_hold() is called after kLongHold
  /// @return false if the oldest frame was dropped for this one.
  template <typename Owner>
  bool put(const WaitingFrame& frame, Owner& owner) {
    frames_.push_back(frame);
    if (frames_.size() <= most_) return true;
    if (!holds_bus_) {
      frames_.pop_front();
      return false;
    }
    if (std::exchange(is_holding_, true)) return true;
    bus_.hold(port_);
    timer_.expires_after(kLongHold);
    timer_.async_wait([kept = owner.shared_from_this()](const AsioError& error) {
      if (!error) kept->report_hold();
    });
    return true;
  }

  [[nodiscard]] bool empty() const noexcept { return frames_.empty(); }

  [[nodiscard]] std::size_t size() const noexcept { return frames_.size(); }

  [[nodiscard]] const WaitingFrame& front() const { return frames_.front(); }

  /// Removes the first frame, which has been sent.
  void pop() {
    frames_.pop_front();
    if (frames_.size() <= most_ / 2) release();
  }

  void clear() {
    frames_.clear();
    release();
  }

 private:
  void release() {
    if (!std::exchange(is_holding_, false)) return;
    cancel(timer_);
    bus_.release(port_);
  }

  asio::steady_timer timer_;
  Bus& bus_;
  const Port& port_;
  std::size_t most_;
  bool holds_bus_;
  bool is_holding_ = false;
  std::deque<WaitingFrame> frames_;
};

}  // namespace vdrive::canopen
