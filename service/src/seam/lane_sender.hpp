// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/wire_region.hpp"

namespace vdrive::service {

/// Sends what waits in the lanes that leave the engine, in the calling thread: a wire in threads of
/// this process, or none.
class LaneSender {
 public:
  LaneSender() = default;
  virtual ~LaneSender() = default;
  LaneSender(const LaneSender&) = delete;
  LaneSender& operator=(const LaneSender&) = delete;

  /// Sends what waits in the lane, as much as one round takes. One thread a lane.
  /// @return whether more may wait.
  virtual bool drain(Lane lane) = 0;

  /// @return whether an answer waits for its reader. For the thread that drains `replies`.
  [[nodiscard]] virtual bool is_holding() const noexcept = 0;
};

}  // namespace vdrive::service
