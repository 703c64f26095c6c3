// SPDX-License-Identifier: Apache-2.0
#include "bench_watch.hpp"

#include <utility>

namespace vdrive::gateway {
namespace {

using std::chrono::milliseconds;

// An announced change wakes the thread immediately; this limits the delay of any other change.
constexpr milliseconds kPeriod{500};

}  // namespace

BenchWatch::BenchWatch(client::Session& session, EventLog& events, FeedSettings settings,
                       BenchNews& news)
    : session_(session), events_(events), settings_(settings), news_(news) {
  session_.watch_services([this](const client::ServiceChange& change) {
    on_change(change);
  });
  const auto take = [this](const client::Event& event) {
    // Stored first: a client that subscribes now and asks for earlier events misses none.
    events_.add(event);
    const std::scoped_lock lock(mutex_);
    const auto feed = feeds_.find(event.bench);
    if (feed != feeds_.end()) feed->second->on_event(event);
  };
  // Includes events that the benches have kept: users may look for one from before this gateway was
  // started.
  session_.on_event(take, client::EventHistory::kept);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

BenchWatch::~BenchWatch() {
  // The callbacks use the feeds, so they are removed first. These calls return when no callback is
  // running.
  session_.watch_services({});
  session_.on_event({});
  thread_.request_stop();
  thread_.join();
  feeds_.clear();
}

BenchList BenchWatch::benches() const {
  const std::scoped_lock lock(mutex_);
  return benches_;
}

std::vector<BenchPresence> BenchWatch::presences() const {
  const auto now = bridge::Roster::Clock::now();
  roster_.refresh(session_.present_benches(), now);
  std::vector<BenchPresence> presences;
  for (const bridge::BenchRecord& record : roster_.all()) {
    presences.push_back({.number = record.info.number,
                         .is_alive = record.is_alive,
                         .sample_age = now - record.newest_sample});
  }
  return presences;
}

void BenchWatch::on_change(const client::ServiceChange& change) {
  roster_.note(change, bridge::Roster::Clock::now());
  const std::scoped_lock lock(mutex_);
  has_changed_ = true;
  changed_.notify_all();
}

void BenchWatch::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    auto found = session_.find_benches();
    if (roster_.take(std::move(found), bridge::Roster::Clock::now())) refresh();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop, kPeriod, [this] {
      return has_changed_;
    });
    has_changed_ = false;
  }
}

bool BenchWatch::continues(const client::BenchInfo& known, const client::BenchInfo& found) const {
  return have_same_topics(known, found);
}

std::optional<std::string> BenchWatch::add(const client::BenchInfo& info) {
  auto feed = std::make_shared<BenchFeed>(session_, roster_, known_bench(info), settings_, news_);
  {
    const std::scoped_lock lock(mutex_);
    feeds_[info.number] = feed;
  }
  news_.came(info.number, feed->channels().all());
  return std::nullopt;
}

void BenchWatch::renew(const client::BenchInfo& info) {
  const std::scoped_lock lock(mutex_);
  feeds_.at(info.number)->note_renewed();
}

void BenchWatch::remove(std::uint32_t bench, bool /*is_replaced*/) {
  std::shared_ptr<BenchFeed> feed;
  {
    const std::scoped_lock lock(mutex_);
    feed = std::move(feeds_.at(bench));
    feeds_.erase(bench);
  }
  // From here on without the lock: the destructor of the feed waits for its thread, and events that
  // arrive in that time need the lock.
  news_.went(bench, feed->channels().all());
}

void BenchWatch::refresh() {
  auto benches = std::make_shared<std::vector<KnownBench>>();
  for (bridge::BenchRecord& record : roster_.all()) {
    benches->push_back(known_bench(std::move(record.info)));
  }
  const std::scoped_lock lock(mutex_);
  benches_ = std::move(benches);
}

}  // namespace vdrive::gateway
