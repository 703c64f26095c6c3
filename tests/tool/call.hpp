// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tool/process.hpp"

#include <functional>
#include <string>
#include <vector>

namespace vdrive::test {

/// Calls the tool for the benches of BenchOnWire: inside this process, with its standard streams
/// from and to memory, or over DDS as a program.
/// @param words the command line, split at blanks
[[nodiscard]] Finished call(const std::string& words, const std::string& input = "");

/// The same with arguments as they are.
[[nodiscard]] Finished call(std::vector<std::string> arguments, const std::string& input = "");

/// Runs a part of the tool with the standard streams of this process from and to memory.
/// @return its exit code, and what it has written
[[nodiscard]] Finished captured(const std::function<int()>& work, const std::string& input = "");

}  // namespace vdrive::test
