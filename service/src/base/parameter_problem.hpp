// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace vdrive::service {

/// What can be wrong with a file of parameters, or with what it holds of one axis.
enum class ParameterProblem : std::uint8_t {
  none,
  unreadable,       ///< number: errno
  empty,            ///< no byte in it
  too_large,        ///< number: its size
  damaged,          ///< not as it was written: torn, changed, or never a file of parameters
  unknown_version,  ///< number: the version
  missing,          ///< gone without an interrupted save, while the one before it is there
  unknown_object,   ///< of an axis: number: index * 256 + sub-index
  refused_value,    ///< of an axis: likewise
};

/// @return such as "damaged" or "version 2 of the format is not supported".
[[nodiscard]] std::string describe_problem(ParameterProblem problem, std::uint64_t number);

}  // namespace vdrive::service
