// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <string_view>

namespace vdrive::test {

/// How much of its scalable work a test does: seeds, moves, datagrams, kills.
template <typename Number>
struct Effort {
  Number usual;    ///< tests/run.sh, which has two minutes
  Number full;     ///< tests/run.sh --full: VDRIVE_FULL=1 in the environment
  Number nightly;  ///< tests/run.sh --nightly: VDRIVE_NIGHTLY=1 in the environment
};

/// @return the amount for this run.
template <typename Number>
[[nodiscard]] Number number_of(const Effort<Number>& effort) {
  const auto is_set = [](const char* variable) {
    const char* const value = std::getenv(variable);
    return value != nullptr && std::string_view(value) == "1";
  };
  if (is_set("VDRIVE_NIGHTLY")) return effort.nightly;
  return is_set("VDRIVE_FULL") ? effort.full : effort.usual;
}

}  // namespace vdrive::test
