// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/wire_region.hpp"

namespace vdrive::service {

/// Sends the records of the engine's outgoing lanes in the calling thread, if the wire runs in
/// threads of this process or the bench has no DDS wire.
class LaneSender {
 public:
  LaneSender() = default;
  virtual ~LaneSender() = default;
  LaneSender(const LaneSender&) = delete;
  LaneSender& operator=(const LaneSender&) = delete;

  /// Sends the waiting records of a lane, up to the limit of one round. One thread per lane.
  /// @return whether more may be waiting
  virtual bool drain(Lane lane) = 0;

  /// @return whether an answer waits for its reader. Only for the thread that drains `replies`.
  [[nodiscard]] virtual bool is_holding() const noexcept = 0;
};

}  // namespace vdrive::service
