// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive {

/// Cyclic synchronous position.
struct CyclicState {
  bool streams = false;  // 607Ah was written since the mode is in force
  bool begins = false;   // no tick has taken that yet
};

}  // namespace vdrive
