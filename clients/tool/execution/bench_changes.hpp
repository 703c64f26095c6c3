// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/axis_finder.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {

/// What commands have changed of benches for everybody, and how it was before.
class BenchChanges {
 public:
  explicit BenchChanges(client::Session& session) : session_(session) {}

  /// An object of an axis was written: a test-bench input that is not 0 is a change.
  void note_write(const client::Axis& axis, ObjectAddress object, std::int64_t value);

  /// @param before the rate of the bench before the first command that set it
  void note_rate(std::uint32_t bench, double before) { rates_before_.emplace(bench, before); }

  /// Clears the test-bench inputs, and gives each bench the rate that it had.
  /// @param axes what the user calls them
  /// @return what was put back, such as "test_blocked_load of 1.1 is 0".
  std::vector<std::string> put_back(const AxisFinder& axes);

 private:
  client::Session& session_;
  std::map<std::pair<client::AxisId, ObjectAddress>, client::Axis> disturbed_;  ///< inputs not 0
  std::map<std::uint32_t, double> rates_before_;
};

}  // namespace vdrive::tool
