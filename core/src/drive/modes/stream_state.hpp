// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive {

/// Whether set-points are streamed.
enum class StreamStage : std::uint8_t {
  none,    // the set-point was not written since the mode is in force
  begins,  // it was; no tick has taken it yet
  runs,
};

/// Cyclic modes and interpolated position: the stream of set-points.
struct StreamState {
  StreamStage stage = StreamStage::none;
  bool written = false;  // a set-point, since a tick last took one
};

}  // namespace vdrive
