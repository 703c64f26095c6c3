// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/reason.hpp"
#include "engine/axis_writer.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_events.hpp"
#include "engine/frame_answers.hpp"
#include "engine/masters.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// Applies a command frame to its axes in one tick, and answers it.
class FrameApplication {
 public:
  FrameApplication(BenchAxes& axes, AxisWriter& writer, Masters& masters, FrameAnswers& answers,
                   BenchEvents& events, Counters& counters);

  void apply(const msg::CommandFrame& frame);

  /// Records that the entire frame was refused.
  void record_refused(const msg::CommandFrame& frame, Reason reason);

 private:
  /// The axis of a command of the frame.
  struct Target {
    std::size_t axis = 0;  ///< index; valid unless refused
    bool is_refused = false;
  };

  /// The purpose of a pass over the registers of a command.
  enum class Pass : std::uint8_t {
    judge,  ///< checks and refuses, writes nothing (for all-or-nothing frames)
    write,
  };

  void begin(const msg::CommandFrame& frame);
  [[nodiscard]] bool mark_named(std::size_t axis);
  [[nodiscard]] Reason admit(const msg::AxisCommand& command, std::uint64_t session,
                             Target& target);
  void apply_each(const msg::CommandFrame& frame);
  void apply_all_or_nothing(const msg::CommandFrame& frame);
  bool pass_registers(const msg::AxisCommand& command, std::size_t axis, Pass pass);
  bool pass_register(std::size_t axis, ObjectRow row, std::int64_t value, Pass pass);
  void apply_controlword(const msg::AxisCommand& command, std::size_t axis, std::uint64_t sequence);
  void record_left_out(const msg::CommandFrame& frame);
  void record_refused(const msg::AxisCommand& command, std::size_t axis, Reason reason);
  void refuse(std::uint16_t axis, ObjectAddress address, Reason reason);

  BenchAxes& axes_;
  AxisWriter& writer_;
  Masters& masters_;
  FrameAnswers& answers_;
  BenchEvents& events_;
  Counters& counters_;
  msg::CommandReply reply_;              ///< to the frame being applied
  std::vector<Target> targets_;          ///< of its commands
  std::vector<std::uint32_t> named_in_;  ///< by index: the last frame that named the axis
  std::uint32_t frame_count_ = 0;
};

}  // namespace vdrive::service
