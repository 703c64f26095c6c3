// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/asio.hpp"
#include "bus/bus.hpp"

#include <chrono>
#include <functional>
#include <utility>

namespace vdrive::canopen {

/// A port's hold of its bus (Bus::hold()), for as long as too many frames wait. One that lasts for
/// kLong of wall time is reported: to its user the bus is dead. For the thread of the bus.
class BusHold final {
 public:
  static constexpr std::chrono::milliseconds kLong{1000};

  BusHold(const asio::any_io_executor& executor, Bus& bus, const Port& port)
      : timer_(executor), bus_(bus), port_(port) {}

  /// Nothing while the port holds the bus already.
  /// @param report called after kLong; it keeps the port alive
  void begin(std::function<void()> report) {
    if (std::exchange(holds_, true)) return;
    bus_.hold(port_);
    timer_.expires_after(kLong);
    timer_.async_wait([told = std::move(report)](const AsioError& error) {
      if (!error) told();
    });
  }

  /// Nothing while the port does not hold the bus.
  void end() {
    if (!std::exchange(holds_, false)) return;
    cancel(timer_);
    bus_.release(port_);
  }

 private:
  asio::steady_timer timer_;
  Bus& bus_;
  const Port& port_;
  bool holds_ = false;
};

}  // namespace vdrive::canopen
