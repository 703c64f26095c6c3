// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "channel.hpp"
#include "directory.hpp"
#include "messages.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/session.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
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

  /// @return all of them.
  [[nodiscard]] std::vector<ChannelPointer> all() const;
};

/// Makes the topics of a bench.
[[nodiscard]] BenchChannels bench_channels(const KnownBench& bench);

/// What feeds have in common.
struct FeedSettings {
  double rate = 60.0;                                 ///< messages of a channel [1/s]
  const std::atomic<std::size_t>* clients = nullptr;  ///< that are connected
};

/// Publishes one bench. A thread of its own follows the bench while some client receives one of its
/// axes, never advances its clock, and encodes what is received once for all receivers.
class BenchFeed {
 public:
  /// @param session outlives the feed
  /// @param publish any thread; takes a batch and does not wait
  BenchFeed(client::Session& session, KnownBench bench, FeedSettings settings, Publish publish);
  ~BenchFeed();
  BenchFeed(const BenchFeed&) = delete;
  BenchFeed& operator=(const BenchFeed&) = delete;

  [[nodiscard]] const BenchChannels& channels() const noexcept { return channels_; }

  /// The bench as it was found last.
  [[nodiscard]] KnownBench bench() const;

  /// The bench was found again, maybe another run of it. One with other axes is ignored: it needs
  /// other topics.
  void update(client::BenchInfo info);

  /// The bench stopped sending, or sends again.
  /// @param sample_age of its newest sample
  void note_alive(bool is_alive, std::chrono::milliseconds sample_age);

  /// How old its newest sample is, by the last call of note_alive().
  [[nodiscard]] std::chrono::nanoseconds sample_age() const;

  /// Since when it has been silent; nothing while it is not.
  [[nodiscard]] std::optional<std::chrono::milliseconds> silence() const;

  void on_event(const client::Event& event);

 private:
  using Clock = std::chrono::steady_clock;

  void run(const std::stop_token& stop);
  [[nodiscard]] bool is_stream_wanted() const;
  void follow(Clock::time_point until);
  bool open_follower();
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
  void publish_description();
  void publish_state(Clock::time_point now);
  [[nodiscard]] std::uint64_t time_of(std::uint64_t tick) const;
  void rest(std::chrono::milliseconds duration, const std::stop_token& stop);

  client::Session& session_;
  const FeedSettings settings_;
  const Publish publish_;
  const BenchChannels channels_;

  mutable std::mutex mutex_;  ///< guards the bench and its presence
  KnownBench bench_;
  bool is_alive_ = true;
  bool has_changed_ = false;
  Clock::time_point newest_sample_{};

  // Of the thread.
  std::uint64_t period_ = 0;  ///< of a tick [ns]
  std::optional<client::Follower> follower_;
  std::optional<client::Observation> newest_;
  bool is_new_ = false;     ///< newest_ was not published
  bool is_urgent_ = false;  ///< it has a state or a fault that was not published
  std::vector<std::uint32_t> published_states_;
  std::uint64_t missed_ = 0;
  std::vector<std::size_t> traced_;    ///< places of the axes
  std::vector<bridge::Trace> traces_;  ///< of all axes
  std::vector<bridge::Joint> joints_;
  std::size_t next_rating_ = 0;  ///< place of the axis whose rating is read next
  Clock::time_point rating_due_{};
  Clock::time_point next_state_{};
  std::condition_variable_any woken_;
  std::jthread thread_;  ///< last: ends before what it uses
};

}  // namespace vdrive::gateway
