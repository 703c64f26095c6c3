// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "engine/frame_answers.hpp"
#include "engine/pending_frames.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>

namespace vdrive::service {

/// The command frames that wait for their tick. A cancelled frame is answered with
/// REASON_CANCELLED.
class FrameSchedule {
 public:
  FrameSchedule(FrameAnswers& answers, Counters& counters);

  /// Takes the content of `frame`, which is due at `tick`. @return false if there is no room.
  [[nodiscard]] bool insert(std::uint64_t tick, msg::CommandFrame& frame);

  /// Moves the first frame that is due at `tick` to `frame`. @return false if none is due.
  [[nodiscard]] bool take_due(std::uint64_t tick, msg::CommandFrame& frame);

  void cancel_all();
  void cancel_of_session(std::uint64_t session);
  /// @param number of the axis
  void cancel_of_axis(std::uint16_t number);

  [[nodiscard]] bool contains(const msg::CommandFrame& frame) const noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return pending_.size(); }

 private:
  template <typename Condition>
  void cancel_if(Condition condition);
  void show_size();

  FrameAnswers& answers_;
  Counters& counters_;
  PendingFrames pending_;
};

}  // namespace vdrive::service
