// SPDX-License-Identifier: Apache-2.0
#include "base/parameter_problem.hpp"

#include "vdrive/number_text.hpp"

#include <system_error>

namespace vdrive::service {

std::string describe_problem(ParameterProblem problem, std::uint64_t number) {
  switch (problem) {
    case ParameterProblem::none:
      return "valid";
    case ParameterProblem::unreadable:
      return "cannot be read: " + std::generic_category().message(static_cast<int>(number));
    case ParameterProblem::empty:
      return "empty";
    case ParameterProblem::too_large:
      return "too large: " + std::to_string(number) + " bytes";
    case ParameterProblem::damaged:
      return "damaged";
    case ParameterProblem::unknown_version:
      return "version " + std::to_string(number) + " of the format is not supported";
    case ParameterProblem::missing:
      return "missing";
    case ParameterProblem::unknown_object:
    case ParameterProblem::refused_value:
      return hex(number >> 8U, 4) + ":" + std::to_string(number & 0xFFU) +
             (problem == ParameterProblem::unknown_object ? " is not an object that can be stored"
                                                          : " has a value out of range");
  }
  return "";
}

}  // namespace vdrive::service
