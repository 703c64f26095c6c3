// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings.hpp"
#include "vdrive/client/bench.hpp"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::ros2 {

/// An axis as ROS knows it.
struct Joint {
  std::string name;
  client::AxisId axis;
  client::Unit unit;
  double si_per_user_unit = 1.0;  ///< [rad or m]
  std::optional<Interface> interface {};

  /// @return "rad" or "m".
  [[nodiscard]] const char* unit_name() const noexcept {
    return unit.kind == client::UnitKind::rotary ? "rad" : "m";
  }
};

/// The joints of a bench, one an axis, in the order of its axes: called as the configuration says,
/// else as the axis, with "bench1_" before it where that is wanted.
[[nodiscard]] std::vector<Joint> joints_of(const client::BenchInfo& bench,
                                           const Settings& settings);

/// Where a joint is: the bench and the place among its axes.
struct JointPlace {
  std::uint32_t bench = 0;
  std::size_t place = 0;
};

/// Which joints there are. A name stands for one axis.
class JointDirectory {
 public:
  /// Adds the joints of a bench.
  /// @return why not, naming the joint: the bench has a name twice, or another bench has it.
  [[nodiscard]] std::optional<std::string> add(std::uint32_t bench,
                                               const std::vector<Joint>& joints);

  void remove(std::uint32_t bench);

  [[nodiscard]] std::optional<JointPlace> find(std::string_view name) const;

 private:
  std::map<std::string, JointPlace, std::less<>> places_;
};

}  // namespace vdrive::ros2
