// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

/// The signatures in the texts of pybind11.
namespace vdrive::python {

/// What stands between two commas of a signature.
struct Parameter {
  std::string_view name;   ///< with the stars of "*", "*args" and "**kwargs"
  std::string_view type;   ///< such as "Optional[str]"; empty where it has none
  std::string_view value;  ///< its default; empty where it has none
};

struct Signature {
  std::string_view name;  ///< in front of the bracket; may be empty
  std::vector<Parameter> parameters;
};

/// @param text such as "wait(self: vdrive.Motion, timeout: float = 60.0) -> None", and more. The
///        signature refers to it.
/// @return nothing for a text that does not begin with a signature.
[[nodiscard]] std::optional<Signature> read_signature(std::string_view text);

}  // namespace vdrive::python
