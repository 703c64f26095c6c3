// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::canopen {

/// Emergency error code of a SYNC with another length than 1019h says (CiA 301, table 26).
inline constexpr std::uint16_t kSyncLength = 0x8240;

/// What the consumer made of a SYNC.
struct SyncReception {
  bool is_used = false;          ///< PDOs are exchanged; not one with a wrong length
  std::uint8_t counter = 0;      ///< 0 = it has none
  std::uint16_t error_code = 0;  ///< emergency to raise; 0 = none
};

/// The SYNC consumer of a node (CiA 301, 7.2.5) with its objects 1005h COB-ID, 1006h communication
/// cycle period [us], 1007h synchronous window length [us], and 1019h synchronous counter overflow
/// value. It does not produce SYNC.
class SyncConsumer {
 public:
  /// With the defaults of the dictionary.
  /// @param period what 1006h may be besides 0 [us]; none = any
  explicit SyncConsumer(std::optional<std::uint32_t> period);

  [[nodiscard]] static bool has(ObjectAddress object) noexcept;

  /// All objects have their defaults again.
  void reset();

  /// No SYNC has come yet.
  void restart();

  /// @return the value of the object; 0 unless has(object).
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const noexcept;

  /// @pre has(object)
  /// @return value_range_exceeded for a COB-ID with one of the bits 11 to 29, with the producer
  ///         bit 30, or with a restricted CAN-ID (bit 31 has no meaning, and stays as written); for
  ///         a period that is not 0 and not that of the constructor; for an overflow value other
  ///         than 0 and 2 to 240; refused_in_present_device_state for another overflow value while
  ///         1006h is not 0; else none: it is in force.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// @return whether `frame` is a data frame in the base format with the CAN-ID of 1005h.
  [[nodiscard]] bool is_sync(const Frame& frame) const noexcept;

  /// A wrong length is raised once, until a SYNC with the right one comes.
  /// @pre is_sync(frame)
  SyncReception receive(const Frame& frame, DriveTime now);

  /// @return whether the last SYNC had a wrong length.
  [[nodiscard]] bool has_error() const noexcept { return has_wrong_length_; }

  /// @return whether more than 1007h has passed since the last SYNC: synchronous RPDOs are then
  ///         dropped until the next one. Never when 1007h is 0, and not before the first SYNC.
  ///         Where time stands between SYNCs, the window has no effect. TPDOs are sent within the
  ///         call that receives SYNC, so that they are never late.
  [[nodiscard]] bool is_window_over(DriveTime now) const noexcept;

 private:
  [[nodiscard]] AbortCode check(std::uint16_t index, std::uint32_t value) const;
  [[nodiscard]] AbortCode check_overflow(std::uint32_t value) const;

  std::optional<std::uint32_t> stepped_period_;
  std::uint32_t cob_id_ = 0;
  std::uint32_t period_ = 0;
  std::uint32_t window_ = 0;
  std::uint32_t overflow_ = 0;
  std::optional<DriveTime> received_{};
  bool has_wrong_length_ = false;
};

}  // namespace vdrive::canopen
