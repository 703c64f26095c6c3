// SPDX-License-Identifier: Apache-2.0
//
// One group across two services: a gantry whose two sides are on different machines. They start and
// arrive in the same tick, because both derive their ticks from synchronised clocks.
//
//   vdrived --bench 1 --axes 1 &
//   vdrived --bench 2 --axes 1 &
//   03_two_services_one_group [domain]
#include <vdrive/client.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

using namespace vdrive::client;

int main(int argc, char** argv) {
  SessionOptions options;
  if (argc > 1) options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  Session session(options);

  const std::vector<std::string> names{"1.1", "2.1"};
  auto gantry = AxisGroup::create(session, names);
  if (!gantry) {
    std::cerr << gantry.outcome().message() << '\n';
    return 1;
  }
  if (const Outcome enabled = gantry->enable_all(); !enabled) {
    std::cerr << enabled.message() << '\n';
    return 1;
  }

  // Both sides are at the same position in every tick, unless a machine is so busy that its bench
  // has to skip ticks, which it reports as an event: then that side lags.
  double skew = 0.0;
  GroupMoveOptions move;
  move.call.progress = [&skew](const GroupProgress& seen) {
    const double left = seen.axes[0].status.position_demand_value;
    const double right = seen.axes[1].status.position_demand_value;
    skew = std::max(skew, std::abs(left - right));
  };
  for (const double position : {20'000.0, -5'000.0, 1'000.0}) {
    const Outcome moved = gantry->move_together(Eigen::Vector2d::Constant(position), move);
    if (!moved) {
      // The message names the axis. Its fault has also stopped the other side.
      std::cerr << moved.message() << '\n';
      return 1;
    }
    std::cout << "both sides at " << position << '\n';
  }
  std::cout << "largest skew of the demands: " << skew << " UU\n";

  const Outcome disabled = gantry->disable_all();
  if (!disabled) std::cerr << disabled.message() << '\n';
  return disabled ? 0 : 1;
}
