// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/rule.hpp"
#include "language/scenario.hpp"
#include "scenarios/scenario_verdict.hpp"

#include <optional>
#include <string>

namespace vdrive::tool {

/// Judges the scenario, as the master of its bench, from the journal of the bench, and adds the
/// findings to `verdict` as a case "judge". A finding at or above `fail_on` fails the scenario.
/// Lines `# judge: off RULE because REASON` of the scenario are exceptions.
/// @param fail_on nothing = no finding fails it
void judge_scenario(const Scenario& scenario, const std::string& journal,
                    std::optional<judge::Severity> fail_on, ScenarioVerdict& verdict);

}  // namespace vdrive::tool
