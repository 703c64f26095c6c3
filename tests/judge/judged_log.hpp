// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judged_drive.hpp"
#include "log/bus_log.hpp"

#include <sstream>
#include <string>
#include <vector>

namespace vdrive::judge {

inline LogVerdict judged(const std::string& log, const DecoderSettings& settings = {}) {
  std::istringstream stream(log);
  return judge_bus_log(stream, settings);
}

/// @return the names of the rules that the masters of `log` broke.
inline std::vector<std::string> rules_in(const std::string& log,
                                         const DecoderSettings& settings = {}) {
  return broken_rules(judged(log, settings).verdict);
}

}  // namespace vdrive::judge
