// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/support/axis_under_test.hpp"

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace vdrive::test {

// Command sequences for one axis in profile position mode, a reference model for them, and a
// scenario that repeats them with `vdrive run`.

/// A write of an object by its variable_name.
struct Command {
  const char* object = "ds402_controlword";
  std::int64_t value = 0;
};

/// Writes before one tick, and the time after them [ticks of 1 ms].
struct Step {
  std::vector<Command> writes;
  std::uint32_t ticks = 1;
};

/// The values that the model expects in a tick.
struct ExpectedTick {
  std::uint16_t statusword = 0;
  std::int64_t mode = 0;
  std::int64_t demand = 0;
  std::int64_t demand_velocity = 0;
};

/// Result of running drive and model side by side.
struct SideBySide {
  std::string difference;               ///< the first one, with its tick, or ""
  std::vector<ExpectedTick> ticks;      ///< up to and including the tick of the difference
  std::map<std::string, int> occurred;  ///< how often each kind of event occurred
};

/// The axis of tests/data/whole_units.yaml.
[[nodiscard]] AxisConfiguration whole_units_axis();

/// @return the abort code that a write to an object of the sequences must get.
[[nodiscard]] AbortCode expected_answer(const Command& command);

[[nodiscard]] SideBySide run_side_by_side(const std::vector<Step>& steps);

/// @return the sequence as a file for `vdrive run`, with the expected status of every tick of
///         `ticks`: the statusword of each tick, mode and demand at the end of each step and of the
///         file.
[[nodiscard]] std::string scenario_of(const std::vector<Step>& steps,
                                      const std::vector<ExpectedTick>& ticks);

/// For rapidcheck's report of a counterexample.
std::ostream& operator<<(std::ostream& out, const Step& step);

}  // namespace vdrive::test
