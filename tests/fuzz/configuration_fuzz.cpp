// SPDX-License-Identifier: Apache-2.0
//
// Any text is either refused with a message that names the file, or gives a configuration that
// survives being printed and read again.
#include "vdrive/service/configuration.hpp"

#include <cstdint>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace vdrive::service;
  const std::string text(data, data + size);
  try {
    const std::string printed = to_yaml(parse_configuration(text, "bench.yaml"));
    if (to_yaml(parse_configuration(printed, "printed.yaml")) != printed) {
      std::abort();
    }
  } catch (const ConfigurationError& error) {
    const std::string message = error.what();
    if (message.find("bench.yaml") == std::string::npos) {
      std::abort();  // what was printed must be readable, and a refusal names its file
    }
  }
  return 0;
}
