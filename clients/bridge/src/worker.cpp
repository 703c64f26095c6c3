// SPDX-License-Identifier: Apache-2.0
#include "worker.hpp"

#include <utility>

namespace vdrive::bridge {

Worker::~Worker() {
  close();
  if (thread_.joinable()) thread_.join();
}

bool Worker::post(std::function<void()> job) {
  const std::scoped_lock lock(mutex_);
  if (is_closed_ || !jobs_.put(std::move(job))) return false;
  if (!thread_.joinable()) {
    has_ended_ = false;
    thread_ = std::thread(&Worker::run, this);
  }
  changed_.notify_one();
  return true;
}

void Worker::close() {
  const std::scoped_lock lock(mutex_);
  is_closed_ = true;
  jobs_.clear();
  changed_.notify_one();
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] {
      return is_closed_ || !jobs_.empty();
    });
    auto job = jobs_.take();
    if (!job) break;
    lock.unlock();
    (*job)();
    job.reset();  // destroys its captures here, without the lock
    lock.lock();
  }
  has_ended_ = true;
}

}  // namespace vdrive::bridge
