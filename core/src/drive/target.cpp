// SPDX-License-Identifier: Apache-2.0
#include "drive/target.hpp"

#include "drive/registers.hpp"
#include "rounding.hpp"

namespace vdrive {

void drop_targets(Drive& drive) {
  DriveState& s = drive.state();
  s.modes = {};
  drive.registers().record_buffer.count = 0;
  s.target.given = false;
  s.plan_due = true;
}

void seed_target(Drive& drive) {
  DriveState& s = drive.state();
  drop_targets(drive);
  s.target.position = nearest(demand_position(drive));
  s.target.arrived = true;
  s.target.given_up = false;
  s.window.dwell = kSaturatedCount;
}

}  // namespace vdrive
