// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_feed.hpp"
#include "event_log.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::gateway {

/// The presence of a bench that has topics.
struct BenchPresence {
  std::uint32_t number = 0;
  bool is_alive = false;
  std::chrono::nanoseconds sample_age{};  ///< age of its newest sample
};

/// Finds benches as they appear and disappear, and keeps a feed for each. A bench that falls silent
/// keeps its topics for a minute; one that announces its end loses them immediately.
class BenchWatch final : private bridge::BenchHost {
 public:
  /// @param session outlives the watch, as do `news`, and `events`, which gets every event
  BenchWatch(client::Session& session, EventLog& events, FeedSettings settings, BenchNews& news);
  ~BenchWatch() override;
  BenchWatch(const BenchWatch&) = delete;
  BenchWatch& operator=(const BenchWatch&) = delete;

  /// @return the benches that have topics now. Thread-safe.
  [[nodiscard]] BenchList benches() const;

  /// @return the benches that have topics now, with the age of their samples. Thread-safe.
  [[nodiscard]] std::vector<BenchPresence> presences() const;

 private:
  void run(const std::stop_token& stop);
  [[nodiscard]] bool continues(const client::BenchInfo& known,
                               const client::BenchInfo& found) const override;
  std::optional<std::string> add(const client::BenchInfo& info) override;
  void renew(const client::BenchInfo& info) override;
  void remove(std::uint32_t bench, bool is_replaced) override;
  void on_change(const client::ServiceChange& change);
  void refresh();

  client::Session& session_;
  EventLog& events_;
  const FeedSettings settings_;
  BenchNews& news_;
  mutable bridge::Roster roster_{*this};
  mutable std::mutex mutex_;  ///< guards the members below
  std::map<std::uint32_t, std::shared_ptr<BenchFeed>> feeds_;
  BenchList benches_ = std::make_shared<std::vector<KnownBench>>();
  std::condition_variable_any changed_;
  bool has_changed_ = false;
  std::jthread thread_;
};

}  // namespace vdrive::gateway
