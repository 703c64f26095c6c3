// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

/// What a rising edge of controlword bit 4 latches (profile position mode).
struct SetPoint {
  std::int32_t position_user_target_value = 0;           ///< 607Ah [user units]
  std::uint32_t profile_velocity = 0;                    ///< 6081h [user units/s]
  std::uint32_t synchronous_move_duration = 0;           ///< 5E10h:01 [us], 0 = off
  std::uint32_t synchronous_move_acceleration_time = 0;  ///< 5E10h:02 [us]
  std::uint32_t synchronous_move_deceleration_time = 0;  ///< 5E10h:03 [us]
  std::uint32_t synchronous_move_jerk_time = 0;          ///< 5E10h:04 [us], 0 = no limit
  std::uint32_t synchronous_move_reference_way = 0;      ///< 5E10h:05 [user units], 0 = from rest
  std::uint16_t positioning_option_code = 0;             ///< 60F2h
  bool relative = false;                                 ///< controlword bit 6
  std::array<std::uint8_t, 1> unused{};  ///< no byte without a value: snapshots have this
};

/// What became of a written controlword.
enum class SetPointOutcome : std::uint8_t {
  none,      ///< no rising edge of bit 4
  started,   ///< becomes the active set-point at once
  buffered,  ///< starts when the active one is reached
  ignored,   ///< not accepted: the buffer is full, or the drive takes no set-points now
};

/// Set-point handshake of profile position mode: one active set-point (the caller's) and one
/// buffered, acknowledged by statusword bit 12 (CiA 402-2; manual, bits 4, 5 and 12).
class SetPointQueue {
 public:
  /// One controlword was written.
  /// @param previous_word the controlword in force before
  /// @param accepting Operation enabled and 6061h = 1 held before and hold after this word
  /// @param moving the active set-point is not reached yet
  /// @param candidate what an edge latches
  SetPointOutcome controlword(std::uint16_t word, std::uint16_t previous_word, bool accepting,
                              bool moving, const SetPoint& candidate) noexcept;

  /// The active set-point was reached: the buffered one, if any, leaves the queue.
  /// @return true when `next` was filled.
  [[nodiscard]] bool take_buffered(std::uint16_t word, SetPoint& next) noexcept;

  /// Drops the buffered set-point; the acknowledge still follows bit 4.
  /// @param word the controlword in force
  void drop_buffered(std::uint16_t word) noexcept;

  /// Drops everything, the acknowledge included.
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
