// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/record.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace vdrive::tool {

/// What commands report to while they wait, and the only place that decides whether a person sees
/// it: on a terminal (standard error), not with --json, and not in a scenario. It is one line about
/// what lasts longer than a second, rewritten in place by a thread of its own, and taken away at
/// the end.
class CommandProgress {
 public:
  /// @param session @param output both have to stay as long as this
  CommandProgress(client::Session& session, const Output& output)
      : session_(session), output_(output) {}

  ~CommandProgress() { end(); }

  CommandProgress(const CommandProgress&) = delete;
  CommandProgress& operator=(const CommandProgress&) = delete;

  /// An axis moves. @param label what the user calls it
  /// @param target [UU] none where it is not known
  void motion(const client::Axis& axis, const std::string& label,
              std::optional<std::int32_t> target);

  /// Something is awaited of an axis. @param what such as "waiting for target_reached"
  void axis(const client::Axis& axis, const std::string& label, std::string what);

  /// Whether an axis has done what was commanded.
  using AxisTest = bool (*)(const client::AxisSnapshot& axis);

  /// Several axes do the same. @param what such as "enable" @param is_done none = not known
  void axes(std::string what, const std::vector<client::Axis>& axes, AxisTest is_done);

  /// Something of which only its time is known. @param what such as "status of 3 axes"
  void time(std::string what);

  /// Whatever `text` says; it is called in the thread of the progress. Empty = no line.
  void tell(std::function<std::string()> text);

  /// The line is gone, and `text` is not called any more. Without a line: nothing.
  void end();

 private:
  client::Session& session_;
  const Output& output_;
  std::jthread thread_;
};

/// Ends the progress, however a block ends.
class EndOfProgress {
 public:
  explicit EndOfProgress(CommandProgress& progress) : progress_(progress) {}

  ~EndOfProgress() { progress_.end(); }

  EndOfProgress(const EndOfProgress&) = delete;
  EndOfProgress& operator=(const EndOfProgress&) = delete;

 private:
  CommandProgress& progress_;
};

/// @return one line, in the unit of the axis alone, such as
///         "axis 1.1: at 96.42 deg of 0.00 deg at -1.14 deg/s, some 85 s more".
[[nodiscard]] std::string motion_text(const client::AxisSnapshot& axis, const std::string& label,
                                      const client::Unit& unit, std::optional<std::int32_t> target);

/// @return such as "axis 1.1: waiting for fault, at 96.42 deg, 0.00 deg/s, Operation enabled".
[[nodiscard]] std::string awaited_text(const client::AxisSnapshot& axis, const std::string& label,
                                       const client::Unit& unit, std::string_view what);

/// @return such as "enable: 412 of 10000 axes".
[[nodiscard]] std::string count_text(std::string_view what, std::size_t done, std::size_t all);

}  // namespace vdrive::tool
