// SPDX-License-Identifier: Apache-2.0
//
// Three axes draw the edges of a tetrahedron. Each edge is a straight line in axis space: all axes
// start in the same tick, keep the ratio of their distances, and arrive in the same tick.
//
//   vdrived --axes 3 &
//   02_three_axis_figure [domain]
#include <Eigen/Geometry>
#include <vdrive/client.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

using namespace vdrive::client;

namespace {

/// Distance of a point from the straight line between two corners [UU].
double distance_from_line(const Eigen::Vector3d& point, const Eigen::Vector3d& from,
                          const Eigen::Vector3d& to) {
  return (point - from).cross(to - from).norm() / (to - from).norm();
}

Eigen::Vector3d demand_of(std::span<const AxisSnapshot> axes) {
  return {static_cast<double>(axes[0].status.position_demand_value),
          static_cast<double>(axes[1].status.position_demand_value),
          static_cast<double>(axes[2].status.position_demand_value)};
}

}  // namespace

int main(int argc, char** argv) {
  SessionOptions options;
  if (argc > 1) options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  Session session(options);

  const std::vector<std::string> names{"1.1", "1.2", "1.3"};
  auto group = AxisGroup::create(session, names);
  if (!group) {
    std::cerr << group.outcome().message() << '\n';
    return 1;
  }
  if (const Outcome enabled = group->enable_all(); !enabled) {
    std::cerr << enabled.message() << '\n';
    return 1;
  }

  const Eigen::Vector3d a(0, 0, 0);
  const Eigen::Vector3d b(8000, 8000, 0);
  const Eigen::Vector3d c(8000, 0, 8000);
  const Eigen::Vector3d d(0, 8000, 8000);
  // Each of the six edges at least once, returning to the start.
  const std::array figure{a, b, c, d, b, c, a, d, a};

  double worst = 0.0;
  for (std::size_t corner = 1; corner < figure.size(); ++corner) {
    GroupMoveOptions move;
    move.velocity_factor = 0.5;  // of the speed of each axis
    move.call.progress = [&](const GroupProgress& seen) {
      worst = std::max(
          worst, distance_from_line(demand_of(seen.axes), figure[corner - 1], figure[corner]));
    };
    if (const Outcome moved = group->move_together(figure[corner], move); !moved) {
      std::cerr << moved.message() << '\n';
      return 1;
    }
    std::cout << "corner " << corner << ": " << figure[corner].transpose() << '\n';
  }
  std::cout << "never farther from an edge than " << worst << " UU\n";

  const Outcome disabled = group->disable_all();
  if (!disabled) std::cerr << disabled.message() << '\n';
  return disabled && worst <= 1.0 ? 0 : 1;
}
