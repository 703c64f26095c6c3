// SPDX-License-Identifier: Apache-2.0
#include "bridge/private_benches.hpp"

#include "settings/configuration_error.hpp"

#include <memory>
#include <string>

namespace vdrive::canopen {
namespace {

bench::BenchOptions options_of(const Settings& settings, const BenchSetting& bench) {
  return {.configuration_file = bench.configuration,
          .axes = bench.axes,
          .preset = bench.preset,
          .clock = settings.clock,
          .number = bench.number,
          .state_directory = settings.state};
}

}  // namespace

void check_private_benches(const Settings& settings) {
  if (!settings.is_private) return;
  for (const BusSetting& bus : settings.buses) {
    for (const BenchSetting& bench : bus.benches) {
      try {
        bench::check(options_of(settings, bench));
      } catch (const bench::BenchError& error) {
        throw vdrive::settings::ConfigurationError("bench " + std::to_string(bench.number) + ": " +
                                                   error.what());
      }
    }
  }
}

std::vector<bench::Bench> make_private_benches(const Settings& settings) {
  std::vector<bench::Bench> benches;
  if (!settings.is_private) return benches;
  std::shared_ptr<wire::LocalBus> meeting;
  for (const BusSetting& bus : settings.buses) {
    for (const BenchSetting& bench : bus.benches) {
      bench::BenchOptions options = options_of(settings, bench);
      options.bus = meeting;
      benches.emplace_back(options);
      meeting = benches.front().bus();
    }
  }
  return benches;
}

}  // namespace vdrive::canopen
