// SPDX-License-Identifier: Apache-2.0
//
// Any text is either refused with a message that names the file, or gives a configuration that the
// service accepts and that survives being printed and read again.
#include "configuration/configuration_file.hpp"
#include "fuzz/support/bytes.hpp"
#include "vdrive/axis_bank.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace {

using namespace vdrive::service;
using vdrive::test::demand;

std::optional<Configuration> parse(const std::string& text) {
  try {
    return parse_configuration(text, "bench.yaml");
  } catch (const ConfigurationError& error) {
    demand(std::string(error.what()).starts_with("bench.yaml"), "a refusal names its file");
    return std::nullopt;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto configuration = parse({data, data + size});
  if (!configuration) return 0;
  check(*configuration);
  const std::string printed = to_yaml(*configuration);
  const auto again = parse(printed);
  demand(again.has_value(), "what was printed can be read");
  demand(to_yaml(*again) == printed, "what was printed reads back to the same");
  vdrive::AxisBank bank(bank_axes(*configuration), configuration->period);
  bank.step();
  return 0;
}
