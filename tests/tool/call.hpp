// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tool/process.hpp"

#include <functional>
#include <string>
#include <vector>

namespace vdrive::test {

/// Calls the tool for the benches of BenchOnWire: either in this process, with its standard streams
/// in memory, or as a program over DDS.
/// @param words the command line, split at spaces
[[nodiscard]] Finished call(const std::string& words, const std::string& input = "");

/// The same with arguments that are not split.
[[nodiscard]] Finished call(std::vector<std::string> arguments, const std::string& input = "");

/// Runs a part of the tool in this process with its standard streams in memory.
/// @return its exit code and output
[[nodiscard]] Finished captured(const std::function<int()>& work, const std::string& input = "");

}  // namespace vdrive::test
