// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/distances.hpp"
#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace vdrive::judge {

/// Targets, limits, and streams of cyclic synchronous position (CiA 402-2).
class MotionRules {
 public:
  /// To be called before the track of `context` is updated with the write.
  void take(const Write& write, const Context& context);

  /// To be called after the track of `context` was updated.
  void take(const Shown& shown, const Context& context);

  void forget();

 private:
  /// The first target of a stream, kept until the length of its steps is known.
  struct FirstTarget {
    std::int64_t target = 0;
    std::int64_t actual = 0;
    std::int64_t longest_step = 0;
    std::uint32_t steps = 0;
  };

  static void take_edge(const Context& context);
  void take_streamed(std::int64_t target, const Context& context);
  void judge_step(std::int64_t step, Time distance, const Context& context);
  void judge_repeat(std::int64_t step, const Context& context);
  void judge_acceleration(std::int64_t target, const Context& context);
  void begin_stream(const Context& context);
  void note_first(std::int64_t target, const Context& context);
  void judge_first(bool is_over, const Context& context);
  void check_limits(std::int64_t target, const Context& context);
  void watch_following(const Context& context);
  void watch_torque(const Context& context);
  void watch_error(const Context& context);

  bool is_following_ = false;       ///< Operation enabled in mode 8
  bool saw_not_following_ = false;  ///< the source shows the axis from before the stream
  bool awaits_first_ = false;
  std::optional<FirstTarget> first_;
  bool was_homed_ = false;   ///< since the last stream
  bool had_target_ = false;  ///< there was a target before that homing
  bool is_homing_attained_ = false;
  std::optional<std::int64_t> last_target_;
  std::int64_t last_step_ = 0;
  std::int64_t step_before_repeat_ = 0;  ///< 0 = the last step was not a repetition
  Time last_time_{};
  Distances distances_;

  /// Every kStepsOfAStretch-th target: the speed between two of them is accurate enough to compare.
  struct Corner {
    std::int64_t target = 0;
    Time time{};
  };

  std::array<Corner, 2> corners_{};  ///< the last ones, oldest first
  std::uint32_t corner_count_ = 0;   ///< number of valid corners
  std::uint32_t steps_ = 0;          ///< since the last corner
  std::uint64_t repeats_ = 0;
  std::uint64_t late_ = 0;
  std::int64_t largest_error_ = 0;
  std::optional<Time> saturated_since_;
  bool is_saturation_reported_ = false;
  bool is_beyond_ = false;  ///< the last target was beyond 607Dh and has been reported
};

}  // namespace vdrive::judge
