// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/reason.hpp"
#include "engine/bench_brake.hpp"
#include "engine/bench_clock.hpp"
#include "engine/frame_answers.hpp"
#include "engine/frame_application.hpp"
#include "engine/frame_schedule.hpp"
#include "engine/masters.hpp"
#include "seam/queues.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstdint>

namespace vdrive::service {

/// Checks arriving command frames, and applies each in the next tick or in its target tick.
class CommandFrames {
 public:
  /// How far in the future the target tick of a frame may be.
  static constexpr std::chrono::seconds kFurthestAhead{10};

  CommandFrames(const BenchClock& clock, const BenchBrake& brake, Masters& masters,
                FrameSchedule& schedule, FrameAnswers& answers, FrameApplication& application,
                Counters& counters);

  /// Handles a frame. If the frame waits for its tick, its content is moved out.
  void handle(Arrival& arrival);

  /// Applies the frames of the next tick.
  void apply_due();

  /// @return whether the command frame `sequence` of `session` has arrived.
  [[nodiscard]] bool has_arrived(std::uint64_t session, std::uint64_t sequence) const noexcept;

 private:
  void refuse(const msg::CommandFrame& frame, Reason reason);
  [[nodiscard]] Reason check_sender(const msg::CommandFrame& frame) const noexcept;
  [[nodiscard]] bool answer_repeat(const msg::CommandFrame& frame);
  [[nodiscard]] Reason check(const Arrival& arrival, const SessionRecord& record) const;
  [[nodiscard]] Reason check_time(const msg::CommandFrame& frame) const;

  const BenchClock& clock_;
  const BenchBrake& brake_;
  Masters& masters_;
  FrameSchedule& schedule_;
  FrameAnswers& answers_;
  FrameApplication& application_;
  Counters& counters_;
  std::uint64_t furthest_ahead_;  ///< [ticks]
  msg::CommandFrame due_frame_;
};

}  // namespace vdrive::service
