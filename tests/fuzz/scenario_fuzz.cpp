// SPDX-License-Identifier: Apache-2.0
//
// Any text is either a scenario or refused with the line's number.
#include "scenario.hpp"
#include "usage_error.hpp"

#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream text(std::string(data, data + size));
  try {
    static_cast<void>(vdrive::tool::parse_scenario(text, "fuzz.scn"));
  } catch (const vdrive::tool::UsageError& error) {
    if (std::string(error.what()).rfind("fuzz.scn:", 0) != 0) {
      std::abort();
    }
  }
  return 0;
}
