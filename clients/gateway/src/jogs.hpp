// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services.hpp"
#include "worker.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace vdrive::gateway {

using SessionPointer = std::shared_ptr<client::Session>;

/// The axes that a client jogs: each runs while the client repeats its request within kHeldTime,
/// then brakes to a standstill. One press is one jog: once it has ended, whether by silence, a stop
/// or a fault, the axis does not run again until the client has released the button (velocity 0).
/// Used in one thread; the calls of each axis run in a thread for that axis.
class Jogs {
 public:
  using Clock = std::chrono::steady_clock;

  /// How long one request keeps an axis running. The page repeats it every 100 ms, and some may be
  /// late. If the client is lost, the axis runs on for this time.
  static constexpr std::chrono::milliseconds kHeldTime{400};

  /// The most axes at a time: each has a thread. Beyond it, a new axis replaces one that has ended
  /// and has not been requested within kHeldTime.
  static constexpr std::size_t kMostAxes = 32;

  /// Called once for each request, in any thread.
  using Answer = std::function<void(const CallAnswer& answer)>;

  explicit Jogs(SessionPointer session) : session_(std::move(session)) {}

  /// Releases all axes and waits until they are at standstill, or until the session is interrupted.
  ~Jogs();
  Jogs(const Jogs&) = delete;
  Jogs& operator=(const Jogs&) = delete;

  /// Runs an axis, or keeps it running; velocity 0 releases it. An axis running at a different
  /// velocity brakes first.
  /// @param answer called when the axis runs, is at standstill, or was refused; failed if the jog
  ///        of this press has ended
  void request(const JogRequest& request, Clock::time_point now, const Answer& answer);

  /// Destroys the threads of axes that the client has released.
  void forget_ended();

 private:
  /// The time until which a press of a button counts.
  using Hold = std::atomic<Clock::time_point>;

  struct Jog {
    std::int32_t velocity = 0;
    std::shared_ptr<Hold> held_until;
    bool is_pressed = false;
    Clock::time_point asked{};           ///< time of its latest request
    std::atomic<std::size_t> calls = 0;  ///< waiting for the worker
    bridge::Worker worker;
  };

  [[nodiscard]] static bool is_running(const Jog& jog, Clock::time_point now);
  static void let_go(Jog& jog);
  template <typename Call>
  static void post(Jog& jog, const Answer& answer, Call call);

  SessionPointer session_;
  std::map<std::string, Jog> jogs_;  ///< by the client's name for the axis
};

}  // namespace vdrive::gateway
