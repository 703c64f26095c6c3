// SPDX-License-Identifier: Apache-2.0
//
// Any text is either a scenario, each line of which has the same meaning on its own, or refused
// with the line number.
#include "base/usage_error.hpp"
#include "command_table.hpp"
#include "fuzz/support/bytes.hpp"
#include "language/scenario.hpp"

#include <cstdint>
#include <sstream>
#include <string>

namespace {

using namespace vdrive::tool;
using vdrive::test::demand;

void check_alone(const ScenarioLine& line) {
  std::istringstream text(line.text);
  const Scenario alone = parse_scenario(commands(), text, "line.scn");
  demand(alone.lines.size() == 1, "the text of a line is one line");
  demand(alone.lines[0].text == line.text, "and keeps its words");
  demand(alone.lines[0].command.row == line.command.row, "and its meaning");
  demand(alone.lines[0].command.refusal == line.command.refusal, "and the refusal that it expects");
  demand(alone.lines[0].timeout == line.timeout, "and its time-out");
  demand(alone.lines[0].command.axes == line.command.axes, "and its axes");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream text(std::string(data, data + size));
  Scenario scenario;
  try {
    scenario = parse_scenario(commands(), text, "fuzz.scn");
  } catch (const UsageError& error) {
    demand(std::string(error.what()).starts_with("fuzz.scn:"), "a refusal names file and line");
    return 0;
  }
  std::size_t last = 0;
  for (const ScenarioLine& line : scenario.lines) {
    demand(line.number > last, "lines count up");
    last = line.number;
    check_alone(line);
  }
  return 0;
}
