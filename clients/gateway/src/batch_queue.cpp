// SPDX-License-Identifier: Apache-2.0
#include "batch_queue.hpp"

namespace vdrive::gateway {

void BatchQueue::put(Batch batch) {
  if (under_way_ >= kMost) {
    ++lost_;
    return;
  }
  ++under_way_;
  post_([this, batch = std::move(batch)] {
    --under_way_;
    take_(batch);
  });
}

}  // namespace vdrive::gateway
