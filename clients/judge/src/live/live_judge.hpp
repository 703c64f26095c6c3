// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string_view>
#include <vector>

namespace vdrive::judge {

/// Judges the masters of a running bench, by the writes that the bench keeps and the status that it
/// publishes from now on. Commands nothing. For one thread at a time.
class LiveJudge {
 public:
  static constexpr std::chrono::milliseconds kPollEvery{100};

  /// @param axes axes of the bench to judge
  /// @return an outcome of the client library if the bench is not there, or does not keep writes
  [[nodiscard]] static client::Result<LiveJudge> create(client::Session& session,
                                                        std::uint32_t bench,
                                                        std::vector<client::Axis> axes);

  /// Processes what has happened since the last call. Each call has a fixed cost, and one call per
  /// kPollEvery is enough, unless the bench is stepped.
  /// @param patience wall time to wait for a status
  /// @return lost if the bench is silent or was restarted; ok also if nothing has happened
  client::Outcome poll(std::chrono::milliseconds patience);

  /// @return drive time from the start to the last judged tick.
  [[nodiscard]] Time judged_time() const noexcept { return time_of(judged_tick_ - first_tick_); }

  /// @return the verdict so far.
  [[nodiscard]] Verdict verdict() const { return judge_.verdict(); }

 private:
  LiveJudge(client::Session& session, const client::BenchInfo& bench, client::Follower follower,
            std::vector<client::Axis> axes);

  [[nodiscard]] Time time_of(std::uint64_t ticks) const noexcept {
    return static_cast<std::int64_t>(ticks) * Time(period_);
  }

  [[nodiscard]] client::Outcome begin();
  [[nodiscard]] client::Outcome show_objects();
  [[nodiscard]] client::Outcome take_samples(std::chrono::milliseconds patience);
  [[nodiscard]] client::Outcome take_writes();
  void judge_until_known();
  void judge_sample(const client::Observation& sample);
  void judge_writes_before(const client::Observation& sample);
  void lose(std::uint64_t tick, std::string_view cause);
  void judge_write(const client::AxisWrite& write, bool is_ignored);
  [[nodiscard]] std::optional<std::size_t> place_of(std::uint16_t axis) const;
  void take(std::uint64_t tick, std::uint32_t axis, const decltype(Record::what)& what);

  client::Session* session_;
  std::uint32_t bench_;
  bool is_realtime_;
  std::chrono::microseconds period_;
  client::Follower follower_;
  std::vector<client::Axis> axes_;
  std::vector<std::uint32_t> ignored_;       ///< set-points so far, by place of the axis
  std::deque<client::Observation> samples_;  ///< waiting for the writes before them
  std::vector<client::Observation> spent_;   ///< their memory is reused
  std::deque<client::AxisWrite> writes_;     ///< waiting for the status after them
  std::uint64_t place_ = 0;                  ///< of the last write
  std::uint64_t known_tick_ = 0;             ///< all writes of earlier ticks have arrived
  std::uint64_t first_tick_ = 0;
  std::uint64_t judged_tick_ = 0;
  Judge judge_;
};

}  // namespace vdrive::judge
