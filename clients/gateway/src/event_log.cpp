// SPDX-License-Identifier: Apache-2.0
#include "event_log.hpp"

#include "messages.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace vdrive::gateway {

void EventLog::add(const client::Event& event) {
  const std::scoped_lock lock(mutex_);
  Bench& bench = benches_[event.bench];
  bench.added = ++added_;
  std::deque<client::Event>& events = bench.events;
  if (event.incarnation != bench.incarnation) {
    events.clear();
    bench.counts.clear();
    bench.incarnation = event.incarnation;
  }
  // Not simply appended: if the bench has suppressed equal events, it sends the last of them up to
  // a second late, with the tick at which that event happened.
  events.insert(std::ranges::upper_bound(events, event.tick, {}, &client::Event::tick), event);
  ++bench.counts[event.kind];
  if (events.size() > kMostOfABench) forget_one(bench);
  if (benches_.size() <= kMostBenches) return;
  benches_.erase(std::ranges::min_element(benches_, {}, [](const auto& entry) {
    return entry.second.added;
  }));
}

void EventLog::forget_one(Bench& bench) {
  const auto most = std::ranges::max_element(bench.counts, {}, [](const auto& entry) {
    return entry.second;
  });
  bench.events.erase(std::ranges::find(bench.events, most->first, &client::Event::kind));
  --most->second;
}

std::vector<client::Event> EventLog::events(std::uint32_t bench) const {
  const std::scoped_lock lock(mutex_);
  const auto found = benches_.find(bench);
  if (found == benches_.end()) return {};
  return {found->second.events.begin(), found->second.events.end()};
}

CallAnswer call_events(const EventLog& log, const Json& request) {
  constexpr NumberRange kBenches{.lowest = 0, .highest = std::numeric_limits<std::uint32_t>::max()};
  const auto bench = optional_integer(request, "bench", kBenches);
  if (!bench) throw ProtocolError("'bench' is missing: the number of a bench, such as 1");
  Json list = Json::array();
  for (const client::Event& event : log.events(static_cast<std::uint32_t>(*bench))) {
    list.push_back({{"tick", event.tick},
                    {"axis", event.axis},
                    {"kind", to_string(event.kind)},
                    {"level", bridge::log_level(event.kind)},
                    {"code", event.code},
                    {"message", bridge::event_text(event)}});
  }
  return {.outcome = {}, .fields = {{"events", std::move(list)}}};
}

}  // namespace vdrive::gateway
