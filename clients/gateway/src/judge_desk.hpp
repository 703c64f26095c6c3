// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"
#include "services.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

namespace vdrive::gateway {

/// Judges the masters of benches for clients that ask, from the first call of /judge on and for as
/// long as somebody asks again. Any thread.
class JudgeDesk {
 public:
  /// Of a bench: judging more would take a core from the page.
  static constexpr std::size_t kMostAxes = 256;
  static constexpr std::size_t kMostBenches = 16;
  /// Nobody asks any more.
  static constexpr std::chrono::seconds kForgottenAfter{10};

  /// @param session outlives the desk
  explicit JudgeDesk(client::Session& session) : session_(session) {}

  /// The answer to /judge: what was found so far.
  /// @throws ProtocolError when the request is wrong
  [[nodiscard]] CallAnswer call(const Json& request);

 private:
  using Clock = std::chrono::steady_clock;

  /// A bench that is judged, by a thread of its own.
  struct Judged {
    std::mutex mutex;
    judge::Verdict verdict{};
    client::Outcome outcome{};  ///< why it is judged no longer
    bool has_begun = false;     ///< there is a verdict
    bool is_unasked = false;    ///< it is judged no longer, because nobody asked
    Clock::time_point asked = Clock::now();
    std::jthread thread{};  ///< last: it uses what is above
  };

  void work(std::uint32_t bench, Judged& judged, const std::stop_token& stop);
  [[nodiscard]] static CallAnswer answer_of(Judged& judged);
  void forget_unasked();

  client::Session& session_;
  std::mutex mutex_;  ///< guards the map
  std::map<std::uint32_t, std::unique_ptr<Judged>> benches_;
};

}  // namespace vdrive::gateway
