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

/// Judges the masters of benches for clients, from the first call of /judge and as long as calls
/// are repeated. Thread-safe.
class JudgeDesk {
 public:
  /// Per bench: judging more axes would occupy a processor core that the page needs.
  static constexpr std::size_t kMostAxes = 256;
  static constexpr std::size_t kMostBenches = 16;
  /// Time without a call after which judging ends.
  static constexpr std::chrono::seconds kForgottenAfter{10};

  /// @param session outlives the desk
  explicit JudgeDesk(client::Session& session) : session_(session) {}

  /// The answer to /judge: the findings so far.
  /// @throws ProtocolError when the request is wrong
  [[nodiscard]] CallAnswer call(const Json& request);

 private:
  using Clock = std::chrono::steady_clock;

  /// A bench that is judged, in its own thread.
  struct Judged {
    std::mutex mutex;
    judge::Verdict verdict{};
    client::Outcome outcome{};  ///< why judging has ended
    bool has_begun = false;     ///< there is a verdict
    bool is_unasked = false;    ///< judging has ended because there were no calls
    Clock::time_point asked = Clock::now();
    std::jthread thread{};  ///< last: it uses the members above
  };

  void work(std::uint32_t bench, Judged& judged, const std::stop_token& stop);
  [[nodiscard]] static CallAnswer answer_of(Judged& judged);
  void forget_unasked();

  client::Session& session_;
  std::mutex mutex_;  ///< guards the map
  std::map<std::uint32_t, std::unique_ptr<Judged>> benches_;
};

}  // namespace vdrive::gateway
