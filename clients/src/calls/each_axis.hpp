// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calls/axes_call.hpp"
#include "calls/axes_stop.hpp"
#include "vdrive/client/axis.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// What a command does; one row a command.
struct EachCommandRow;

/// A command to axes of one bench, each of which has an outcome of its own: one that refuses it or
/// fails does not keep it from the others. All of them have the same time-out. Its parts are called
/// in their order; several of them, for more axes than fit into a frame, wait together.
class EachAxis {
 public:
  /// @param axes of one bench, each once, at most msg::MAX_AXES_PER_FRAME
  EachAxis(std::shared_ptr<SessionCore> core, std::span<const AxisId> axes, EachCommand command,
           const CallOptions& options);

  /// Connects, without waiting for the status of the axes.
  void open();

  /// Observes the axes, takes control of them, and judges which of them can take the command.
  void begin();

  /// Others have waited since begin(): observes the axes as they are now, and judges them anew.
  void refresh();

  /// Sends the command to them; a stop and a power cycle wait for await_in_force().
  void send();

  /// Waits until the command is in force.
  /// @param stepped benches in lock-step of which another one has let a tick pass since send();
  ///        that of this one is added when it does
  void await_in_force(std::set<std::uint32_t>& stepped);

  /// Ends the status of the axes when none of them waits for it any more.
  void close_unless_pending();

  /// Waits until every axis that took it has done what was commanded.
  void finish();

  /// @return whether an axis has no outcome yet.
  [[nodiscard]] bool has_pending() const;

  [[nodiscard]] const std::vector<Outcome>& outcomes() const noexcept { return outcomes_; }

 private:
  Outcome begin_call();
  Outcome acquire();
  [[nodiscard]] bool goes_by_frames() const;
  /// @return whether an axis that has not ended is in a state that cannot take the command.
  [[nodiscard]] bool refuses_any() const;
  void judge();
  void await_before();
  Outcome stop();
  Outcome power_cycle();
  void judge_in_force();
  void judge_enabling(std::size_t place);
  void end_faulty(std::size_t place);
  [[nodiscard]] std::vector<std::size_t> pending_places() const;
  void await_operation();
  void await_reset();
  void await_standstill();
  void await_targets();
  void await_state(PowerState state);

  void await_quick_stops();
  template <typename Done>
  void await_each(std::string_view awaited, std::uint64_t from, const Done& done);
  void fail_unless(std::string_view awaited, bool (*holds)(const AxisSnapshot&));
  void end(std::size_t place, Outcome outcome);
  void end_all(const Outcome& outcome);

  [[nodiscard]] std::vector<Round> rounds() const;

  std::shared_ptr<SessionCore> core_;
  AxesCall call_;
  std::optional<AxesStop> stop_;
  const EachCommandRow& row_;
  CallOptions options_;
  std::vector<Outcome> outcomes_;  ///< by place
  std::vector<bool> is_pending_;   ///< by place: the outcome is still open
  std::uint64_t from_ = 0;         ///< tick in which a power cycle has switched the axes on again
  std::vector<AxisSnapshot> at_end_;  ///< by place: when the last wait for the axis ended
};

/// Gives a command to axes of any benches: first to all of them, then waits for all.
/// @return one outcome an axis, in their order
[[nodiscard]] std::vector<Outcome> command_each(const std::shared_ptr<SessionCore>& core,
                                                std::span<const AxisId> axes, EachCommand command,
                                                const CallOptions& options);

}  // namespace vdrive::client
