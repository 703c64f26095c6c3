// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"
#include "vdrive/client/outcome.hpp"

#include <string>
#include <utility>

/// Converts outcomes to Python exceptions, whose classes are in vdrive/_errors.py.
namespace vdrive::python {

/// @param outcome not ok
/// @return its exception object.
[[nodiscard]] py::object exception_of(const client::Outcome& outcome);

/// @throws py::error_already_set with exception_of(outcome)
[[noreturn]] void raise(const client::Outcome& outcome);

/// @throws py::error_already_set with a ConfigurationError
[[noreturn]] void raise_configuration_error(const std::string& message);

/// @throws py::error_already_set unless the outcome is ok
inline void check(const client::Outcome& outcome) {
  if (!outcome) raise(outcome);
}

/// @return the value.
/// @throws py::error_already_set if there is none
template <typename Value>
Value value_or_raise(client::Result<Value>&& result) {
  if (!result) raise(result.outcome());
  return std::move(result).value();
}

}  // namespace vdrive::python
