// SPDX-License-Identifier: Apache-2.0
#include "bench_watch.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::gateway {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPeriod{500};
constexpr std::chrono::minutes kSilenceOfTopics{1};

}  // namespace

BenchWatch::BenchWatch(client::Session& session, FeedSettings settings, BenchEvents events)
    : session_(session), settings_(settings), events_(std::move(events)) {
  session_.watch_services([this](const client::ServiceChange& change) {
    on_change(change);
  });
  session_.on_event([this](const client::Event& event) {
    const std::scoped_lock lock(mutex_);
    const auto feed = feeds_.find(event.bench);
    if (feed != feeds_.end()) feed->second->on_event(event);
  });
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

BenchWatch::~BenchWatch() {
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
  std::vector<client::BenchInfo> present = session_.present_benches();
  const std::scoped_lock lock(mutex_);
  for (client::BenchInfo& info : present) {
    const auto feed = feeds_.find(info.number);
    if (feed != feeds_.end()) feed->second->update(std::move(info));
  }
  std::vector<BenchPresence> presences;
  presences.reserve(feeds_.size());
  for (const auto& [number, feed] : feeds_) {
    presences.push_back(
        {.number = number, .is_alive = !feed->silence(), .sample_age = feed->sample_age()});
  }
  return presences;
}

void BenchWatch::on_change(const client::ServiceChange& change) {
  const std::scoped_lock lock(mutex_);
  const auto feed = feeds_.find(change.bench);
  if (feed != feeds_.end()) {
    const bool is_alive = change.news != client::ServiceNews::fell_silent &&
                          change.news != client::ServiceNews::went_offline;
    feed->second->note_alive(is_alive, change.silence);
  }
  if (change.news == client::ServiceNews::went_offline) offline_.push_back(change.bench);
  has_changed_ = true;
  changed_.notify_all();
}

void BenchWatch::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    reconcile(session_.find_benches());
    remove_silent();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop, kPeriod, [this] {
      return has_changed_;
    });
    has_changed_ = false;
  }
}

void BenchWatch::reconcile(std::vector<client::BenchInfo> found) {
  bool is_new = false;
  for (client::BenchInfo& info : found) {
    std::shared_ptr<BenchFeed> feed;
    {
      const std::scoped_lock lock(mutex_);
      const auto known = feeds_.find(info.number);
      if (known != feeds_.end()) feed = known->second;
    }
    if (feed && have_same_topics(feed->bench().info, info)) {
      is_new = is_new || feed->bench().info.incarnation != info.incarnation;
      // Found, so it is alive: a report of its silence may be older than this.
      if (feed->bench().info.incarnation != info.incarnation) feed->note_alive(true, {});
      feed->update(std::move(info));
      continue;
    }
    if (feed) remove(info.number);
    if (info.axes.empty()) continue;
    add(std::move(info));
    is_new = true;
  }
  if (is_new) refresh();
}

void BenchWatch::add(client::BenchInfo info) {
  const std::uint32_t number = info.number;
  auto feed = std::make_shared<BenchFeed>(session_, known_bench(std::move(info)), settings_,
                                          events_.publish);
  {
    const std::scoped_lock lock(mutex_);
    feeds_[number] = feed;
    std::erase(offline_, number);
  }
  events_.came(number, feed->channels().all());
}

void BenchWatch::remove(std::uint32_t bench) {
  std::shared_ptr<BenchFeed> feed;
  {
    const std::scoped_lock lock(mutex_);
    const auto known = feeds_.find(bench);
    if (known == feeds_.end()) return;
    feed = std::move(known->second);
    feeds_.erase(known);
  }
  events_.went(bench, feed->channels().all());
  refresh();
}

void BenchWatch::remove_silent() {
  std::vector<std::uint32_t> gone;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [number, feed] : feeds_) {
      const auto silence = feed->silence();
      const bool is_offline = std::ranges::find(offline_, number) != offline_.end();
      if (silence && (is_offline || *silence > kSilenceOfTopics)) gone.push_back(number);
    }
    offline_.clear();
  }
  for (const std::uint32_t bench : gone) remove(bench);
}

void BenchWatch::refresh() {
  const std::scoped_lock lock(mutex_);
  auto benches = std::make_shared<std::vector<KnownBench>>();
  benches->reserve(feeds_.size());
  for (const auto& [number, feed] : feeds_) benches->push_back(feed->bench());
  benches_ = std::move(benches);
}

}  // namespace vdrive::gateway
