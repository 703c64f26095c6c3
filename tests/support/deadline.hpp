// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <iostream>
#include <string>
#include <string_view>

namespace vdrive::test {

/// @return "[deadline] WHAT in 40 s", the text that a wait writes when it times out. The mark lets
///         tests/checks/failures.py distinguish a missed deadline from a wrong value.
inline std::string missed_deadline(std::string_view what, std::chrono::milliseconds patience) {
  const auto count = static_cast<double>(patience.count()) / 1000.0;
  std::string text = std::to_string(count);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return "[deadline] " + std::string(what) + " in " + text + " s";
}

/// Writes that text to standard error. Call it before the expectation that fails for this reason.
inline void report_missed_deadline(std::string_view what, std::chrono::milliseconds patience) {
  std::cerr << missed_deadline(what, patience) + "\n";
}

}  // namespace vdrive::test
