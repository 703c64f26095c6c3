// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>

namespace vdrive::python {

/// An object created, kept and destroyed by a dedicated thread; for objects with a child process.
/// The system ends the child when the thread that started it ends. The dedicated thread ends only
/// with the object or with this process, so the object can be used from any thread, and the child
/// ends when this process is killed.
template <typename Kept>
class ThreadOwned {
 public:
  using Make = std::function<std::unique_ptr<Kept>()>;

  /// Waits until the object has been created.
  /// @throws as `make` does
  explicit ThreadOwned(Make make) {
    std::promise<Kept*> made;
    std::future<Kept*> answer = made.get_future();
    thread_ = std::jthread(
        [recipe = std::move(make)](const std::stop_token& stop, std::promise<Kept*> promise) {
          keep(recipe, stop, promise);
        },
        std::move(made));
    kept_ = answer.get();
  }

  /// The object; null after end().
  [[nodiscard]] Kept* get() const noexcept { return kept_; }

  /// Destroys the object and waits for that. Can be called repeatedly.
  void end() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
    kept_ = nullptr;
  }

 private:
  static void keep(const Make& make, const std::stop_token& stop, std::promise<Kept*>& made) {
    try {
      const std::unique_ptr<Kept> kept = make();
      std::promise<void> ended;
      const std::stop_callback end(stop, [&ended] {
        ended.set_value();
      });
      made.set_value(kept.get());
      ended.get_future().wait();
    } catch (const std::exception&) {
      made.set_exception(std::current_exception());
    }
  }

  Kept* kept_ = nullptr;
  std::jthread thread_;
};

}  // namespace vdrive::python
