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
/// then brakes and stands. One press is one jog: whatever has ended it, be it silence, a stop or a
/// fault, the axis does not run again until the client has let it go (velocity 0). For one thread;
/// the calls of each axis wait in a thread of its own.
class Jogs {
 public:
  using Clock = std::chrono::steady_clock;

  /// How long a request keeps an axis running. The page repeats it every 100 ms, and some may be
  /// late. An axis whose client is lost runs on for this long.
  static constexpr std::chrono::milliseconds kHeldTime{400};

  /// Axes at a time: each has a thread. Beyond them an axis gets the place of one that has ended
  /// and for which no request has come within kHeldTime.
  static constexpr std::size_t kMostAxes = 32;

  /// Called once for each request, in any thread.
  using Answer = std::function<void(const CallAnswer& answer)>;

  explicit Jogs(SessionPointer session) : session_(std::move(session)) {}

  /// Lets go of all axes and waits until they stand, or until the session is interrupted.
  ~Jogs();
  Jogs(const Jogs&) = delete;
  Jogs& operator=(const Jogs&) = delete;

  /// Runs an axis, or lets it run on; with velocity 0 lets it go. An axis that runs at another
  /// velocity brakes first.
  /// @param answer when the axis runs, when it stands, or when it was refused; failed where the jog
  ///        of this press has ended
  void request(const JogRequest& request, Clock::time_point now, const Answer& answer);

  /// Drops the threads of axes that the client has let go.
  void forget_ended();

 private:
  /// Until when a press of a button counts.
  using Hold = std::atomic<Clock::time_point>;

  struct Jog {
    std::int32_t velocity = 0;
    std::shared_ptr<Hold> held_until;
    bool is_pressed = false;
    Clock::time_point asked{};           ///< when the last request for it came
    std::atomic<std::size_t> calls = 0;  ///< that the worker has to do
    bridge::Worker worker;
  };

  [[nodiscard]] static bool is_running(const Jog& jog, Clock::time_point now);
  static void let_go(Jog& jog);
  template <typename Call>
  static void post(Jog& jog, const Answer& answer, Call call);

  SessionPointer session_;
  std::map<std::string, Jog> jogs_;  ///< by the name that the client gives the axis
};

}  // namespace vdrive::gateway
