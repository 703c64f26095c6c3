// SPDX-License-Identifier: Apache-2.0
#include "streams/refusal_watcher.hpp"

#include <stop_token>
#include <utility>

namespace vdrive::client {

void RefusalWatcher::watch(std::function<void(const SetPointRefusal&)> observer) {
  links_.watch_refusals({});
  thread_.stop();  // ends the last watch
  if (!observer) return;
  waiting_->clear();
  thread_.start(
      [this, waiting = waiting_, observe = std::move(observer)](const std::stop_token& stop) {
        failure_.run([&] {
          while (const auto refusal = waiting->next(stop)) observe(*refusal);
        });
      });
  // Not this object: the links outlive it, and replies arrive until they end.
  links_.watch_refusals([waiting = waiting_](const SetPointRefusal& refusal) {
    waiting->put(refusal);
  });
}

}  // namespace vdrive::client
