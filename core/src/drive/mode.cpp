// SPDX-License-Identifier: Apache-2.0
#include "drive/mode.hpp"

namespace vdrive {

void ignore_edge(Drive& drive, const WrittenControlword& word) {
  DriveState& s = drive.state();
  if ((s.controlword & ~word.previous & Controlword::kNewSetPoint) != 0) ++s.ignored_set_points;
}

}  // namespace vdrive
