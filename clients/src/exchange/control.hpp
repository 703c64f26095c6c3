// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/periodic_thread.hpp"
#include "exchange/bench_links.hpp"
#include "exchange/command_history.hpp"
#include "exchange/exchange.hpp"
#include "exchange/held_axes.hpp"
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

/// Acquires axes, keeps them and releases them. Thread-safe.
class Control {
 public:
  Control(KeepAlive keep_alive, Exchange& exchange, HeldAxes& held_axes, CommandHistory& history,
          BenchLinks& links, SessionNames& names);

  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  /// Acquires all of these axes, or none.
  /// @param by_force take axes from other sessions too
  Outcome acquire(const Target& target, std::span<const std::uint16_t> axes, bool by_force = false);

  /// @return whether this session has acquired all of these and has not learned that it lost one.
  [[nodiscard]] bool holds(const Target& target, std::span<const std::uint16_t> axes);

  /// Sends a request that must be answered before further frames are sent, such as a power cycle:
  /// nothing else is sent to the bench until then.
  Result<RequestAnswer> exchange(const Target& target, msg::Request request, std::string_view what);

  /// Writes objects of one axis; if one is a command object, this acquires the axis.
  Result<RequestAnswer> write(const Target& target, msg::Request request, std::string_view what);

  /// Writes `word`, a halt or a quick stop, to axes of any owner.
  /// @return the tick in which it takes effect; refused, naming the first axis that refused it.
  Result<std::uint64_t> stop(const Target& target, std::span<const std::uint16_t> axes,
                             std::uint16_t word);

  /// Releases all axes except those that are running and were not seen to stop: these stay with
  /// this session until the watchdog of their bench stops them.
  /// @return failed, naming the axes that stay, if there are any
  Outcome release();

  /// As release(), for one bench.
  Outcome release(std::uint32_t bench);

  /// Ends the keep-alives and releases all axes: the session acquires none after this.
  void end();

 private:
  Outcome acquire_part(const Target& target, std::span<const std::uint16_t> axes, bool by_force);
  Outcome release(const ReleasedAxes& given);
  Outcome release(const Target& target, std::span<const std::vector<std::uint16_t>> parts);
  Result<RequestAnswer> carry_out(const Target& target, msg::Request request,
                                  std::string_view what);
  void note_acquired(const Target& target, std::span<const std::uint16_t> axes,
                     const msg::Reply& reply);

  void start_keep_alive();
  [[nodiscard]] std::chrono::milliseconds send_keep_alive();

  const KeepAlive keep_alive_;
  Exchange& exchange_;
  HeldAxes& held_axes_;
  CommandHistory& history_;
  SessionNames& names_;
  BenchLinks& links_;
  std::once_flag keeps_alive_;
  PeriodicThread keep_alive_thread_;
};

}  // namespace vdrive::client
