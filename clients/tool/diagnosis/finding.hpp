// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::tool {

enum class Severity : std::uint8_t {
  good,
  hint,     ///< works, but not at its best, or not for every use
  problem,  ///< benches will not be found, or not run
};

/// One thing that was checked.
struct Finding {
  Severity severity = Severity::good;
  std::string subject;                    ///< such as "multicast"
  std::string text;                       ///< what was found
  std::string advice;                     ///< what to do; empty when good
  std::vector<client::Figure> figures{};  ///< of a bench; for programs only
};

}  // namespace vdrive::tool
