// SPDX-License-Identifier: Apache-2.0
#include "streams/refusal_watcher.hpp"

#include "base/report_queue.hpp"

#include <cstddef>
#include <memory>
#include <stop_token>
#include <utility>

namespace vdrive::client {
namespace {

// A program may count them: 256 frames of 256 values each fit.
constexpr std::size_t kMostRefusalsWaiting = 65'536;

}  // namespace

void RefusalWatcher::watch(std::function<void(const SetPointRefusal&)> observer) {
  links_.watch_refusals({});
  thread_.stop();  // ends the last watch
  if (!observer) return;
  const auto waiting = std::make_shared<ReportQueue<SetPointRefusal, kMostRefusalsWaiting>>();
  thread_.start([this, waiting, observe = std::move(observer)](const std::stop_token& stop) {
    failure_.run([&] {
      while (const auto refusal = waiting->next(stop)) observe(*refusal);
    });
  });
  links_.watch_refusals([waiting](const SetPointRefusal& refusal) {
    waiting->put(refusal);
  });
}

}  // namespace vdrive::client
