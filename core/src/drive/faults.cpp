// SPDX-License-Identifier: Apache-2.0
#include "drive/faults.hpp"

#include "drive/registers.hpp"

#include <algorithm>
#include <cstddef>

namespace vdrive {

bool note_heat(Drive& drive, double heat) {
  LoadLevel& level = drive.state().faults.load_level;
  const LoadLevel before = level;
  if (heat <= kWarningHeat) {
    level = LoadLevel::rated;
  } else if (heat >= kFaultHeat) {
    level = LoadLevel::fault;
  } else if (before == LoadLevel::rated) {
    level = LoadLevel::warning;
  }
  return level != before;
}

bool cause_present(const Drive& drive) {
  const bool by_input = std::ranges::any_of(kFaultCauses, [&drive](const FaultCause& cause) {
    return reg(drive, cause.input) != 0;
  });
  return by_input || drive.state().faults.load_level == LoadLevel::fault;
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
