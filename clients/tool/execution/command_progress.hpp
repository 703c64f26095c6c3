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

/// The progress of waiting commands, and the only place that decides whether it is shown: on a
/// terminal (standard error), not with --json, and not in a scenario. A wait of more than a second
/// is shown in one line, which its own thread rewrites in place and removes at the end.
class CommandProgress {
 public:
  /// @param session, output must outlive this object
  CommandProgress(client::Session& session, const Output& output)
      : session_(session), output_(output) {}

  ~CommandProgress() { end(); }

  CommandProgress(const CommandProgress&) = delete;
  CommandProgress& operator=(const CommandProgress&) = delete;

  /// Shows an axis on its way.
  /// @param label the axis as the user has typed it
  /// @param target [UU] none if unknown
  void motion(const client::Axis& axis, const std::string& label,
              std::optional<std::int32_t> target);

  /// Shows an axis while the command waits for it.
  /// @param what such as "waiting for target_reached"
  void axis(const client::Axis& axis, const std::string& label, std::string what);

  /// Whether an axis has done what was commanded.
  using AxisTest = bool (*)(const client::AxisSnapshot& axis);

  /// Shows how many of several axes have carried out a command.
  /// @param what such as "enable"
  /// @param is_done nullptr = not known
  void axes(std::string what, const std::vector<client::Axis>& axes, AxisTest is_done);

  /// Shows only how long an activity has taken so far.
  /// @param what such as "status of 3 axes"
  void time(std::string what);

  /// Shows the result of `text`, which is called in the progress thread. Empty = no line.
  void tell(std::function<std::string()> text);

  /// Removes the line; `text` is not called any more. Does nothing without a line.
  void end();

 private:
  client::Session& session_;
  const Output& output_;
  std::jthread thread_;
};

/// Ends the progress when the block is left.
class EndOfProgress {
 public:
  explicit EndOfProgress(CommandProgress& progress) : progress_(progress) {}

  ~EndOfProgress() { progress_.end(); }

  EndOfProgress(const EndOfProgress&) = delete;
  EndOfProgress& operator=(const EndOfProgress&) = delete;

 private:
  CommandProgress& progress_;
};

/// @return one line, only in the unit of the axis, such as "axis 1.1: at 96.42 deg, target
///         0.00 deg, -1.14 deg/s, about 85 s left".
[[nodiscard]] std::string motion_text(const client::AxisSnapshot& axis, const std::string& label,
                                      const client::Unit& unit, std::optional<std::int32_t> target);

/// @return such as "axis 1.1: waiting for fault, at 96.42 deg, 0.00 deg/s, Operation enabled".
[[nodiscard]] std::string awaited_text(const client::AxisSnapshot& axis, const std::string& label,
                                       const client::Unit& unit, std::string_view what);

/// @return such as "enable: 412 of 10000 axes".
[[nodiscard]] std::string count_text(std::string_view what, std::size_t done, std::size_t all);

}  // namespace vdrive::tool
