// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"

#include <string>

namespace vdrive::tool {

struct MeasurementOptions {
  std::string service;    ///< the program vdrived
  bool is_quick = false;  ///< short parts, at most 1,024 axes
  bool is_json = false;
};

/// `vdrive bench`: measures this machine, on benches of its own that end with it.
ExitCode run_measurement(const MeasurementOptions& options, Interrupt& interrupt,
                         Terminal& terminal);

}  // namespace vdrive::tool
