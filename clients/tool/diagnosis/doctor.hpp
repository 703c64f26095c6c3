// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diagnosis/finding.hpp"
#include "language/global_options.hpp"
#include "output/report.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/outcome.hpp"

#include <functional>
#include <vector>

namespace vdrive::tool {

/// `vdrive doctor`: reads the machine, finds the benches, and shows the findings.
/// @return failed when there is a problem.
/// @param find finds the benches on the domain; what it throws is a problem
client::Outcome run_doctor(const GlobalOptions& options, Terminal& terminal,
                           const std::function<std::vector<client::BenchInfo>()>& find);

/// @return a line of `vdrive doctor --json`.
[[nodiscard]] Json finding_json(const Finding& finding);

}  // namespace vdrive::tool
