// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace vdrive::service {

/// A problem with a parameter file, or with the parameters of one axis in it.
enum class ParameterProblem : std::uint8_t {
  none,
  unreadable,       ///< number: errno
  empty,            ///< 0 bytes
  too_large,        ///< number: size [bytes]
  damaged,          ///< torn, modified, or never a parameter file
  unknown_version,  ///< number: the version
  missing,          ///< although the previous file exists and no save was interrupted
  unknown_object,   ///< of an axis; number: index * 256 + sub-index
  refused_value,    ///< of an axis; number: as for unknown_object
};

/// @return for example "damaged" or "version 2 of the format is not supported".
[[nodiscard]] std::string describe_problem(ParameterProblem problem, std::uint64_t number);

}  // namespace vdrive::service
