// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive_messages.h"

#include <cstdint>

namespace vdrive::service {

/// Why a request, a command frame or the write of one object is refused: a reason of the wire
/// contract (REASON_...), or an abort code of the dictionary (CiA 301, table "SDO abort codes").
/// The wire has one number for both, and they do not overlap.
class Reason {
 public:
  /// Not refused.
  constexpr Reason() noexcept = default;

  /// A constant REASON_... of the wire contract; no other number compiles.
  // NOLINTNEXTLINE(google-explicit-constructor,hicpp-explicit-conversions): `return
  // msg::REASON_...`
  consteval Reason(std::uint32_t reason) : code_(reason) {
    if (reason >= kFirstAbortCode) is_no_reason_of_the_wire_contract();
  }

  // NOLINTNEXTLINE(google-explicit-constructor,hicpp-explicit-conversions): `return code`
  constexpr Reason(AbortCode code) noexcept : code_(wire_code(code)) {}

  /// @return the number on the wire, in the counters and in events.
  [[nodiscard]] constexpr std::uint32_t code() const noexcept { return code_; }

  [[nodiscard]] constexpr bool is_abort_code() const noexcept { return code_ >= kFirstAbortCode; }

  friend constexpr bool operator==(Reason, Reason) noexcept = default;

 private:
  /// No constant expression: a wrong number does not compile.
  static void is_no_reason_of_the_wire_contract() noexcept {}

  /// That of the standard's table with the lowest number.
  static constexpr std::uint32_t kFirstAbortCode = wire_code(AbortCode::toggle_bit_not_alternated);

  std::uint32_t code_ = msg::REASON_NONE;
};

}  // namespace vdrive::service
