// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "py_session.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/session.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::python {

/// Passes items from a C++ thread to Python: bounded; when it is full, the oldest is dropped. A
/// program with its own loop waits for the file descriptor. No C++ thread ever runs Python.
template <typename Item>
class Queue {
 public:
  explicit Queue(std::size_t capacity)
      : file_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), items_(capacity, WhenFull::drops_oldest) {}

  ~Queue() { ::close(file_); }

  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  void push(Item item) {
    const std::scoped_lock lock(mutex_);
    items_.put(std::move(item));
    notify();
  }

  /// Ends the queue because its source has ended.
  /// @param why the outcome of the source; failed after an error
  void end(client::Outcome why) {
    const std::scoped_lock lock(mutex_);
    if (has_ended_) return;
    has_ended_ = true;
    outcome_ = std::move(why);
    notify();
  }

  /// Ends the wait of take(), now and later, until wait_again(). Any thread.
  void wake() {
    const std::scoped_lock lock(mutex_);
    is_woken_ = true;
    changed_.notify_all();
  }

  void wait_again() {
    const std::scoped_lock lock(mutex_);
    is_woken_ = false;
  }

  /// Waits until there is an item, at most for `patience`.
  /// @return the oldest items, up to `most`; also empty if the source has ended.
  std::deque<Item> take(std::size_t most, std::chrono::nanoseconds patience) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [this] {
      return !items_.empty() || has_ended_ || is_woken_;
    });
    std::deque<Item> taken;
    if (items_.size() <= most) {
      taken = items_.take_all();
    } else {
      while (taken.size() < most) {
        if (auto item = items_.take()) taken.push_back(std::move(*item));
      }
    }
    // The file stays readable at the end, so that every thread waiting for it is woken by the end.
    if (items_.empty() && !has_ended_) forget();
    return taken;
  }

  /// @return the outcome of the source once everything has been taken, otherwise nothing.
  [[nodiscard]] std::optional<client::Outcome> ended() const {
    const std::scoped_lock lock(mutex_);
    if (!has_ended_ || !items_.empty()) return std::nullopt;
    return outcome_;
  }

  [[nodiscard]] std::uint64_t dropped() const {
    const std::scoped_lock lock(mutex_);
    return items_.dropped();
  }

  /// A file descriptor that is readable while there are items, and after the end.
  [[nodiscard]] int file() const noexcept { return file_; }

 private:
  void notify() {
    const std::uint64_t one = 1;
    const ssize_t written = write(file_, &one, sizeof one);
    static_cast<void>(written);
    changed_.notify_all();
  }

  void forget() const {
    std::uint64_t count = 0;
    const ssize_t got = read(file_, &count, sizeof count);
    static_cast<void>(got);
  }

  const int file_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  BoundedQueue<Item> items_;
  bool has_ended_ = false;
  bool is_woken_ = false;
  client::Outcome outcome_;
};

/// Follows the status stream of axes on a separate thread.
class StatusQueue final : public Dependent {
 public:
  StatusQueue(std::shared_ptr<client::Session> session, client::Follower follower,
              std::vector<client::AxisId> axes, std::size_t capacity);
  ~StatusQueue() override;
  StatusQueue(const StatusQueue&) = delete;
  StatusQueue& operator=(const StatusQueue&) = delete;

  void close() noexcept override;

  /// @throws py::error_already_set in a forked process
  [[nodiscard]] Queue<client::Observation>& queue() {
    origin.require_own("the stream");
    return queue_;
  }

  [[nodiscard]] const std::vector<client::AxisId>& axes() const noexcept { return axes_; }

 private:
  void run(const std::stop_token& stop);

  std::mutex closing_;
  std::vector<client::AxisId> axes_;
  Queue<client::Observation> queue_;
  std::shared_ptr<client::Session> session_;
  std::optional<client::Follower> follower_;
  std::jthread thread_;
};

/// The newest state of axes of one bench, at a fixed rate.
class ReportQueue final : public Dependent {
 public:
  /// @throws py::error_already_set if an axis is not there
  ReportQueue(const SharedPySession& py_session, const std::vector<client::AxisId>& axes,
              std::chrono::milliseconds period);
  ~ReportQueue() override;
  ReportQueue(const ReportQueue&) = delete;
  ReportQueue& operator=(const ReportQueue&) = delete;

  void close() noexcept override;

  /// @throws py::error_already_set in a forked process
  [[nodiscard]] Queue<client::Observation>& queue() {
    origin.require_own("the observer");
    return *queue_;
  }

 private:
  std::shared_ptr<Queue<client::Observation>> queue_;
  std::mutex mutex_;
  std::shared_ptr<client::Session> session_;
  std::optional<client::StatusReports> reports_;
};

/// The reports of one kind, such as events, to which a session has only one observer: a new queue
/// replaces the previous one, which ends.
template <typename Item>
class ReportedQueue final : public Dependent {
 public:
  /// Makes the session report to `queue`, or to nobody.
  using Observe = std::function<void(client::Session& session, std::shared_ptr<Queue<Item>> queue)>;

  ReportedQueue(std::shared_ptr<client::Session> session, std::size_t capacity, Observe observe)
      : queue_(std::make_shared<Queue<Item>>(capacity)),
        session_(std::move(session)),
        observe_(std::move(observe)) {
    observe_(*session_, queue_);
  }

  ~ReportedQueue() override { close(); }

  ReportedQueue(const ReportedQueue&) = delete;
  ReportedQueue& operator=(const ReportedQueue&) = delete;

  void close() noexcept override {
    if (origin.is_inherited()) return;
    const std::scoped_lock lock(mutex_);
    if (session_) observe_(*session_, nullptr);
    end();
  }

  /// Ends the queue without touching the session: another queue replaces it.
  void detach() noexcept {
    if (origin.is_inherited()) return;
    const std::scoped_lock lock(mutex_);
    end();
  }

  /// @throws py::error_already_set in a forked process
  [[nodiscard]] Queue<Item>& queue() {
    origin.require_own("the stream");
    return *queue_;
  }

 private:
  void end() noexcept {
    session_.reset();
    queue_->end({});
  }

  std::shared_ptr<Queue<Item>> queue_;
  std::mutex mutex_;
  std::shared_ptr<client::Session> session_;
  Observe observe_;
};

using EventQueue = ReportedQueue<client::Event>;            ///< events of benches
using ServiceQueue = ReportedQueue<client::ServiceChange>;  ///< services that appear and disappear

/// Follows axes tick by tick on the thread of the caller.
class StepFollower final : public Dependent {
 public:
  explicit StepFollower(client::Follower follower);

  void close() noexcept override;

  /// As client::Follower.
  /// @return failed after close()
  client::Outcome next(std::chrono::milliseconds patience, client::Observation& sample);

  /// As client::Follower.
  /// @return also true after close(), false while a call of another thread waits
  [[nodiscard]] bool has_next();

  /// As client::Follower; works after close() too.
  client::Lateness lateness();

 private:
  std::mutex mutex_;
  std::optional<client::Follower> follower_;
  client::Lateness last_lateness_;  ///< of a closed follower
};

}  // namespace vdrive::python
