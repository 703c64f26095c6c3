// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_follower.hpp"
#include "channel.hpp"
#include "descriptions.hpp"
#include "directory.hpp"
#include "messages.hpp"
#include "owner_log.hpp"
#include "roster.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/session.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

namespace vdrive::gateway {

/// The topics of a bench.
struct BenchChannels {
  ChannelPointer status;
  ChannelPointer description;
  ChannelPointer state;
  ChannelPointer events;
  ChannelPointer joints;
  std::vector<ChannelPointer> axis_status;  ///< in the order of the axes
  std::vector<ChannelPointer> axis_trace;

  /// @return all topics of the bench.
  [[nodiscard]] std::vector<ChannelPointer> all() const;
};

/// Creates the topics of a bench.
[[nodiscard]] BenchChannels bench_channels(const KnownBench& bench);

/// Settings shared by all feeds.
struct FeedSettings {
  double rate = 60.0;                                 ///< messages per channel [1/s]
  const std::atomic<std::size_t>* clients = nullptr;  ///< number of connected clients
};

/// Receives the news of benches. Called in threads of the gateway; must not block.
class BenchNews {
 public:
  virtual ~BenchNews() = default;

  virtual void came(std::uint32_t bench, const std::vector<ChannelPointer>& channels) = 0;
  virtual void went(std::uint32_t bench, const std::vector<ChannelPointer>& channels) = 0;
  virtual void publish(Batch batch) = 0;
};

/// Publishes one bench. Its thread follows the bench while a client receives one of the axes, never
/// advances the bench's clock, and encodes each message once for all receivers.
class BenchFeed {
 public:
  /// @param session outlives the feed, as do `roster`, which knows the bench, and `news`
  BenchFeed(client::Session& session, bridge::Roster& roster, KnownBench bench,
            FeedSettings settings, BenchNews& news);
  ~BenchFeed() = default;
  BenchFeed(const BenchFeed&) = delete;
  BenchFeed& operator=(const BenchFeed&) = delete;

  [[nodiscard]] const BenchChannels& channels() const noexcept { return channels_; }

  /// The bench was found again after a restart, possibly with a different description.
  void note_renewed() noexcept { is_renewed_ = true; }

  void on_event(const client::Event& event);

 private:
  using Clock = std::chrono::steady_clock;

  void run(const std::stop_token& stop);
  [[nodiscard]] bool is_stream_wanted() const;
  void follow(Clock::time_point until);
  bool begin();
  void take(client::Observation&& observation);
  void trace(const client::Observation& observation);
  [[nodiscard]] bool has_news(const client::Observation& observation) const;
  void observe_once();
  void choose_traces();
  void publish_axes();
  void refresh_joints(Clock::time_point now);
  void read_rating(std::size_t place);
  void add_axes(Batch& batch);
  void add_traces(Batch& batch);
  void send(const ChannelPointer& channel, std::uint64_t time, std::string message) const;
  void publish_description();
  void publish_state(Clock::time_point now);
  [[nodiscard]] OwnerNames owner_names() const;
  [[nodiscard]] std::uint64_t time_of(std::uint64_t tick) const;

  client::Session& session_;
  bridge::Roster& roster_;
  const FeedSettings settings_;
  BenchNews& news_;
  const BenchChannels channels_;

  const KnownBench bench_;  ///< as first found
  const std::vector<client::AxisId> ids_;
  std::atomic<bool> is_renewed_ = false;
  OwnerLog owners_;

  // Used by the thread only.
  bridge::BenchFollower follower_;
  std::optional<client::Observation> newest_;
  bool is_new_ = false;     ///< newest_ has not been published
  bool is_urgent_ = false;  ///< newest_ has an unpublished state or fault
  std::vector<std::uint32_t> published_states_;
  std::uint64_t missed_ = 0;
  std::vector<std::size_t> traced_;    ///< indices of the axes
  std::vector<bridge::Trace> traces_;  ///< of all axes
  std::vector<bridge::Joint> joints_;
  std::size_t next_rating_ = 0;  ///< index of the axis whose rating is read next
  Clock::time_point rating_due_{};
  Clock::time_point next_state_{};
  std::jthread thread_;  ///< last: ends before the members it uses
};

}  // namespace vdrive::gateway
