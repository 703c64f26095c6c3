// SPDX-License-Identifier: Apache-2.0
#include "base/exit_code.hpp"

namespace vdrive::tool {

ExitCode exit_code_of(client::OutcomeKind kind) noexcept {
  using client::OutcomeKind;
  switch (kind) {
    case OutcomeKind::ok:
      return ExitCode::ok;
    case OutcomeKind::refused:
      return ExitCode::refused;
    case OutcomeKind::timed_out:
      return ExitCode::timed_out;
    case OutcomeKind::not_found:
      return ExitCode::not_found;
    case OutcomeKind::lost:
    case OutcomeKind::failed:
      return ExitCode::failed;
  }
  return ExitCode::failed;
}

}  // namespace vdrive::tool
