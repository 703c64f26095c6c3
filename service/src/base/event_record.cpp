// SPDX-License-Identifier: Apache-2.0
#include "base/event_record.hpp"

#include <cstring>
#include <system_error>

namespace vdrive::service {

std::string SystemError::text() const {
  return std::generic_category().message(number);
}

std::string StoredProblem::text() const {
  return describe_problem(problem, number);
}

std::string WireLoss::text() const {
  const std::string number = std::to_string(value);
  switch (cause) {
    case Cause::signal: {
      const char* const name = sigdescr_np(static_cast<int>(value));
      return "ended by signal " + number + (name == nullptr ? "" : " (" + std::string(name) + ")");
    }
    case Cause::exit_code:
      return "ended with exit code " + number;
    case Cause::no_start:
      return "not ready after 10 s";
    case Cause::hangs:
      return "hung: its send and receive loops did not run for 2 s";
    case Cause::deaf:
      return "received nothing: no test sample arrived for 4 s";
    case Cause::memory:
      return "used " + number + " MiB of memory, more than its limit";
  }
  return "gone";
}

}  // namespace vdrive::service
