// SPDX-License-Identifier: Apache-2.0
#include "language/bench_names.hpp"

namespace vdrive::tool {

BenchNames names_of(client::Session& session) {
  const auto axes = [&session] {
    std::vector<std::string> words;
    for (const client::BenchInfo& bench : session.find_benches()) {
      for (const client::AxisInfo& axis : bench.axes) {
        words.push_back(to_string(axis.id));
        if (!axis.name.empty()) words.push_back(axis.name);
      }
    }
    return words;
  };
  const auto benches = [&session] {
    std::vector<std::string> words;
    for (const client::BenchInfo& bench : session.find_benches()) {
      words.push_back(std::to_string(bench.number));
    }
    return words;
  };
  return {axes, benches};
}

}  // namespace vdrive::tool
