// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

/// The values latched by a rising edge of controlword bit 4 (profile position mode).
struct SetPoint {
  std::int32_t position_user_target_value = 0;           ///< 607Ah [user units]
  std::uint32_t profile_velocity = 0;                    ///< 6081h [user units/s]
  std::uint32_t synchronous_move_duration = 0;           ///< 5E10h:01 [us], 0 = off
  std::uint32_t synchronous_move_acceleration_time = 0;  ///< 5E10h:02 [us]
  std::uint32_t synchronous_move_deceleration_time = 0;  ///< 5E10h:03 [us]
  std::uint32_t synchronous_move_jerk_time = 0;          ///< 5E10h:04 [us], 0 = no limit
  std::uint32_t synchronous_move_reference_way = 0;      ///< 5E10h:05 [user units], 0 = none
  std::uint16_t positioning_option_code = 0;             ///< 60F2h
  bool relative = false;                                 ///< controlword bit 6
  std::array<std::uint8_t, 1> unused{};  ///< no uninitialised padding: snapshots contain it
};

/// Effect of a written controlword on the set-points.
enum class SetPointOutcome : std::uint8_t {
  none,      ///< no rising edge of bit 4
  started,   ///< becomes the active set-point immediately
  buffered,  ///< starts when the active one is reached
  ignored,   ///< not accepted: the buffer is full, or the drive takes no set-points now
};

/// Set-point handshake of profile position mode: one active set-point, which the caller keeps, and
/// one buffered; statusword bit 12 acknowledges them (CiA 402-2; manual, bits 4, 5 and 12).
class SetPointQueue {
 public:
  /// Processes one written controlword.
  /// @param previous_word the controlword in force before this one
  /// @param accepting whether the drive is in Operation enabled with 6061h = 1, before and after
  ///        this word
  /// @param moving whether the active set-point has not been reached yet
  /// @param candidate the values to latch on an edge
  SetPointOutcome controlword(std::uint16_t word, std::uint16_t previous_word, bool accepting,
                              bool moving, const SetPoint& candidate) noexcept;

  /// Called when the active set-point is reached: moves the buffered one, if any, to `next`.
  /// @return true when `next` was filled.
  [[nodiscard]] bool take_buffered(std::uint16_t word, SetPoint& next) noexcept;

  /// Drops the buffered set-point; the acknowledge bit still follows bit 4.
  /// @param word the controlword in force
  void drop_buffered(std::uint16_t word) noexcept;

  /// Drops everything, including the acknowledge bit.
  void clear() noexcept;

  /// @return statusword bit 12: set on acceptance, cleared when bit 4 is 0 and the buffer is free.
  [[nodiscard]] bool acknowledge() const noexcept { return acknowledge_; }

  [[nodiscard]] bool full() const noexcept { return full_; }

 private:
  void release_acknowledge(std::uint16_t word) noexcept;

  SetPoint buffered_;
  bool full_ = false;
  bool acknowledge_ = false;
  [[maybe_unused]] std::array<std::uint8_t, 2> unused_{};
};

}  // namespace vdrive
