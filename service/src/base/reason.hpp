// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::service {

/// Why a request, a command frame or the write of one object was refused: a reason of the wire
/// contract, or an abort code of the dictionary (CiA 301, table "SDO abort codes"). On the wire
/// both share one number; their ranges do not overlap.
class Reason {
 public:
  /// Not refused.
  constexpr Reason() noexcept = default;

  // NOLINTNEXTLINE(google-explicit-constructor,hicpp-explicit-conversions): `return
  // msg::Reason::...`
  constexpr Reason(msg::Reason reason) noexcept : code_(reason) {}

  // NOLINTNEXTLINE(google-explicit-constructor,hicpp-explicit-conversions): `return code`
  constexpr Reason(AbortCode code) noexcept : code_(static_cast<msg::Reason>(wire_code(code))) {}

  /// @return the reason as messages contain it.
  [[nodiscard]] constexpr msg::Reason on_wire() const noexcept { return code_; }

  /// @return the number, as in counters and events.
  [[nodiscard]] constexpr std::uint32_t code() const noexcept {
    return static_cast<std::uint32_t>(code_);
  }

  [[nodiscard]] constexpr bool is_abort_code() const noexcept { return code() >= kFirstAbortCode; }

  friend constexpr bool operator==(Reason, Reason) noexcept = default;

 private:
  /// The lowest number in the table of the standard.
  static constexpr std::uint32_t kFirstAbortCode = wire_code(AbortCode::toggle_bit_not_alternated);

  msg::Reason code_ = msg::Reason::none;
};

}  // namespace vdrive::service
