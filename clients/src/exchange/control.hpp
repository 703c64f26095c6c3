// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/periodic_thread.hpp"
#include "exchange/bench_links.hpp"
#include "exchange/command_history.hpp"
#include "exchange/exchange.hpp"
#include "exchange/holdings.hpp"
#include "exchange/session_names.hpp"
#include "presence/target.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstdint>
#include <mutex>
#include <span>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// Takes control of axes, keeps it and gives it back. Thread-safe.
class Control {
 public:
  Control(KeepAlive keep_alive, Exchange& exchange, Holdings& holdings, CommandHistory& history,
          BenchLinks& links, SessionNames& names);

  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  /// Takes these axes, all or none.
  /// @param by_force also from other sessions
  Outcome acquire(const Target& target, std::span<const std::uint16_t> axes, bool by_force = false);

  /// @return whether this session took all of these and has not received the loss of them.
  [[nodiscard]] bool holds(const Target& target, std::span<const std::uint16_t> axes);

  /// A request whose answer frames have to wait for, such as a power cycle: none is sent to the
  /// bench until it is answered.
  Result<RequestAnswer> exchange(const Target& target, msg::Request request, std::string_view what);

  /// Writes objects of one axis, which takes the axis when one of them is a command object.
  Result<RequestAnswer> write(const Target& target, msg::Request request, std::string_view what);

  /// Writes `word`, a halt or a quick stop, to axes of any owner.
  /// @return the tick in which it is in force; refused, naming the first axis that refused it.
  Result<std::uint64_t> stop(const Target& target, std::span<const std::uint16_t> axes,
                             std::uint16_t word);

  /// Gives all axes back, but those that run and were not seen to stop: they stay with this session
  /// until the watchdog of their bench stops them.
  /// @return failed, naming them, when there are some
  Outcome release();

  /// The same of one bench.
  Outcome release(std::uint32_t bench);

  /// Ends the keep-alives and gives all axes back: the session takes none any more.
  void end();

 private:
  Outcome acquire_part(const Target& target, std::span<const std::uint16_t> axes, bool by_force);
  Outcome release(const GivenBack& given);
  Outcome release(const Target& target, std::span<const std::vector<std::uint16_t>> parts);
  Result<RequestAnswer> carry_out(const Target& target, msg::Request request,
                                  std::string_view what);
  void note_acquired(const Target& target, std::span<const std::uint16_t> axes,
                     const msg::Reply& reply);

  void start_keep_alive();
  [[nodiscard]] std::chrono::milliseconds send_keep_alive();

  const KeepAlive keep_alive_;
  Exchange& exchange_;
  Holdings& holdings_;
  CommandHistory& history_;
  SessionNames& names_;
  BenchLinks& links_;
  std::once_flag keeps_alive_;
  PeriodicThread keep_alive_thread_;
};

}  // namespace vdrive::client
