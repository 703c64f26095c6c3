// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdrive::judge {

/// Returns the display name of an axis, such as "node 5" or "1.1".
using AxisName = std::function<std::string(std::uint32_t axis)>;

/// A rule that a master breaks on purpose.
struct Exception {
  Rule rule{};
  std::string axis{};    ///< by name; empty = every axis
  std::string reason{};  ///< never empty
  std::string place{};   ///< where it is declared, such as "exceptions.yaml:3"
};

/// Moves the findings that are covered by an exception to Verdict::excepted.
/// @return the exceptions that cover no finding.
std::vector<Exception> except(Verdict& verdict, const std::vector<Exception>& exceptions,
                              const AxisName& name_of);

}  // namespace vdrive::judge
