// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::canopen {

/// Emergency error code of a SYNC whose length contradicts 1019h (CiA 301, table 26).
inline constexpr std::uint16_t kSyncLength = 0x8240;

/// The outcome of a received SYNC.
struct SyncReception {
  bool is_used = false;          ///< PDOs are exchanged; false if its length is wrong
  std::uint8_t counter = 0;      ///< 0 = none
  std::uint16_t error_code = 0;  ///< emergency to raise; 0 = none
};

/// The SYNC consumer of a node (CiA 301, 7.2.5) with the objects 1005h COB-ID, 1006h communication
/// cycle period [us], 1007h synchronous window length [us], and 1019h synchronous counter overflow
/// value. It does not produce SYNC.
class SyncConsumer {
 public:
  /// Starts with the defaults of the dictionary.
  /// @param period that 1006h accepts besides 0 [us]; none = any
  explicit SyncConsumer(std::optional<std::uint32_t> period);

  [[nodiscard]] static bool has(ObjectAddress object) noexcept;

  /// Sets all objects back to their defaults.
  void reset();

  /// Forgets all earlier SYNCs.
  void restart();

  /// @return the value of the object; 0 unless has(object).
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const noexcept;

  /// @pre has(object)
  /// @return value_range_exceeded for a COB-ID with any of bits 11 to 29, the producer bit 30, or a
  ///         restricted CAN-ID (bit 31 has no meaning and is kept as written); for a period that is
  ///         neither 0 nor the one of the constructor; for an overflow value other than 0 and 2 to
  ///         240; refused_in_present_device_state for a change of the overflow value while 1006h is
  ///         not 0; otherwise none: the value is in force.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// @return whether `frame` is a data frame in the base format with the CAN-ID of 1005h.
  [[nodiscard]] bool is_sync(const Frame& frame) const noexcept;

  /// A length error is raised once, and again only after a SYNC with the right length.
  /// @pre is_sync(frame)
  SyncReception receive(const Frame& frame, DriveTime now);

  /// @return whether the last SYNC had a wrong length.
  [[nodiscard]] bool has_error() const noexcept { return has_wrong_length_; }

  /// @return whether more than 1007h has passed since the last SYNC, so that synchronous RPDOs are
  ///         dropped until the next one. Never if 1007h is 0, and not before the first SYNC. Where
  ///         time stands still between SYNCs, the window has no effect. TPDOs are never late: they
  ///         are sent within the call that receives SYNC.
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
