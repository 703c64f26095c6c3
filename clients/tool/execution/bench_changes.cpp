// SPDX-License-Identifier: Apache-2.0
#include "execution/bench_changes.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

namespace vdrive::tool {

void BenchChanges::note_write(const client::Axis& axis, ObjectAddress object, std::int64_t value) {
  if (!has_role(object, Role::test_input)) return;
  disturbed_.erase(std::pair(axis.id(), object));
  if (value != 0) disturbed_.emplace(std::pair(axis.id(), object), axis);
}

std::vector<std::string> BenchChanges::put_back(const AxisFinder& axes) {
  std::vector<std::string> done;
  for (const auto& [bench, rate] : std::exchange(rates_before_, {})) {
    if (!session_.set_rate(bench, rate)) continue;
    done.push_back("rate of bench " + std::to_string(bench) + " is " + to_text(rate));
  }
  for (auto& [input, axis] : std::exchange(disturbed_, {})) {
    const auto row = find_object(input.second);
    if (!row || !axis.write(input.second, 0)) continue;
    done.push_back(std::string(describe(*row).variable_name) + " of " + axes.label_of(input.first) +
                   " is 0");
  }
  return done;
}

}  // namespace vdrive::tool
