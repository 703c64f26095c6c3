// SPDX-License-Identifier: Apache-2.0
#include "drive/faults.hpp"

#include "drive/registers.hpp"

#include <algorithm>
#include <cstddef>

namespace vdrive {

bool cause_present(const Drive& drive) {
  return std::ranges::any_of(kFaultCauses, [&drive](const FaultCause& cause) {
    return reg(drive, cause.input) != 0;
  });
}

void enter_fault(Drive& drive, ErrorCode code) {
  FaultState& faults = drive.state().faults;
  faults.error_code = static_cast<std::uint16_t>(code);
  faults.error_register =
      static_cast<std::uint8_t>(faults.error_register | error_register_of(code));
  ++faults.count;
  ErrorHistory& history = drive.registers().history;
  std::copy_backward(history.codes.begin(), history.codes.end() - 1, history.codes.end());
  history.codes[0] = static_cast<std::uint32_t>(code);
  history.count =
      static_cast<std::uint8_t>(std::min<std::size_t>(history.count + 1U, history.codes.size()));
}

void clear_fault(Drive& drive) {
  DriveState& s = drive.state();
  s.faults.error_code = 0;
  s.faults.error_register = 0;
  s.faults.coasting = false;
  s.following_error.shown = false;
  s.following_error.count = 0;
}

void clear_history(Drive& drive) {
  drive.registers().history = {};
}

}  // namespace vdrive
