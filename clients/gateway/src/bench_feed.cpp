// SPDX-License-Identifier: Apache-2.0
#include "bench_feed.hpp"

#include "descriptions.hpp"
#include "joint_values.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace vdrive::gateway {
namespace {

using std::chrono::milliseconds;

// The longest delay until a feed notices a new subscriber or a request to end.
constexpr milliseconds kIdle{50};
// The state is sent even without new ticks: users see within a second that a bench is silent.
constexpr milliseconds kStatePeriod{200};
// A fault is published sooner than `rate` allows, but axes that fail in quick succession share a
// message.
constexpr milliseconds kUrgentPeriod{5};
// Reading a rating is a request to the drive, and blocks the thread that follows the bench.
constexpr milliseconds kRatingPeriod{200};
// [ticks] per message. A freerun bench produces more in a period than a client can take.
constexpr std::size_t kLongestTrace = 1024;

ChannelInfo ros_channel(std::string topic, bridge::MessageSchema schema) {
  return {.id = next_channel_id(),
          .topic = std::move(topic),
          .encoding = "cdr",
          .schema_name = std::move(schema.name),
          .schema = std::move(schema.text),
          .schema_encoding = "ros2msg"};
}

ChannelPointer make(ChannelInfo info) {
  return std::make_shared<Channel>(std::move(info));
}

/// The values whose changes are published immediately: the power state and the error.
std::uint32_t news_of(const AxisStatus& status) {
  constexpr std::uint32_t kErrorPlace = 8;
  const auto state = static_cast<std::uint32_t>(decode_power_state(status.ds402_statusword));
  return state | static_cast<std::uint32_t>(status.error_code) << kErrorPlace;
}

/// Reads the torque rating of an axis, and waits for it.
/// @return its effort_per_mille(); none if it cannot be read
std::optional<double> read_effort_per_mille(const client::Axis& axis, const Unit& unit) {
  using namespace literals;
  constexpr std::array kObjects{kObjectRows["motor_rated_torque"_object].address,
                                kObjectRows["gear_ratio_numerator"_object].address,
                                kObjectRows["gear_ratio_denominator"_object].address};
  const auto readings = axis.read(kObjects);
  if (!readings) return std::nullopt;
  const auto& values = readings->objects;
  ensure(values.size() == kObjects.size(), "each object that is read has a reading");
  return bridge::effort_per_mille(unit, {.motor_rated_torque = values[0].value,
                                         .gear_ratio_numerator = values[1].value,
                                         .gear_ratio_denominator = values[2].value});
}

}  // namespace

std::uint32_t next_channel_id() {
  static std::atomic<std::uint32_t> last = 0;
  return ++last;
}

std::vector<ChannelPointer> BenchChannels::all() const {
  std::vector<ChannelPointer> channels{status, description, state, events, joints};
  channels.insert(channels.end(), axis_status.begin(), axis_status.end());
  channels.insert(channels.end(), axis_trace.begin(), axis_trace.end());
  return channels;
}

BenchChannels bench_channels(const KnownBench& bench) {
  const std::string topic = "/" + bench.topic + "/";
  BenchChannels channels;
  channels.status = make(ros_channel(topic + "status", bridge::bench_status_schema()));
  channels.description = make(description_channel(topic + "description"));
  channels.state = make(state_channel(topic + "state"));
  channels.events = make(ros_channel(topic + "events", bridge::log_schema()));
  channels.joints = make(ros_channel(topic + "joint_states", bridge::joint_states_schema()));
  const bridge::MessageSchema status = bridge::axis_status_schema();
  const bridge::MessageSchema trace = bridge::axis_trace_schema();
  for (const std::string& name : bench.axis_names) {
    channels.axis_status.push_back(make(ros_channel(topic + name + "/status", status)));
    channels.axis_trace.push_back(make(ros_channel(topic + name + "/trace", trace)));
  }
  return channels;
}

BenchFeed::BenchFeed(client::Session& session, bridge::Roster& roster, KnownBench bench,
                     FeedSettings settings, BenchNews& news)
    : session_(session),
      roster_(roster),
      settings_(settings),
      news_(news),
      channels_(bench_channels(bench)),
      bench_(std::move(bench)),
      ids_(bridge::ids_of(bench_.info)),
      follower_(bridge::follow_axes(session, ids_)),
      published_states_(bench_.info.axes.size()),
      traces_(bench_.info.axes.size()) {
  joints_.reserve(bench_.info.axes.size());
  for (std::size_t i = 0; i < bench_.info.axes.size(); ++i) {
    traces_[i].axis = bench_.info.axes[i].id.axis;
    joints_.push_back(
        {.name = bench_.axis_names[i],
         .scale = {.si_per_user_unit = bridge::si_per_user_unit(bench_.info.axes[i].unit)}});
  }
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

void BenchFeed::on_event(const client::Event& event) {
  owners_.note(event);
  if (!channels_.events->is_wanted()) return;
  std::string name = bench_.topic;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (ids_[i].axis == event.axis) name += "/" + bench_.axis_names[i];
  }
  const std::uint64_t time = time_of(event.tick);
  send(channels_.events, time, bridge::encode_event(event, name, time));
}

void BenchFeed::send(const ChannelPointer& channel, std::uint64_t time, std::string message) const {
  news_.publish({.bench = bench_.info.number,
                 .time = time,
                 .messages = {{channel, share(std::move(message))}}});
}

void BenchFeed::run(const std::stop_token& stop) {
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1.0 / settings_.rate));
  Clock::time_point due = Clock::now();
  while (!stop.stop_requested()) {
    // Without clients nothing is followed, because following loads the bench.
    if (*settings_.clients == 0) {
      follower_.close();
      bridge::rest(kIdle, stop);
      continue;
    }
    publish_description();
    publish_state(Clock::now());
    if (!is_stream_wanted()) {
      follower_.close();
      newest_.reset();
      bridge::rest(kIdle, stop);
      continue;
    }
    if (!follower_.is_open() && !begin()) {
      bridge::rest(kIdle, stop);
      continue;
    }
    // A late message does not shift later ones, unless it is late by more than a period.
    due = std::max(due + period, Clock::now());
    follow(due);
    publish_axes();
  }
}

bool BenchFeed::is_stream_wanted() const {
  const auto is_wanted = [](const ChannelPointer& channel) {
    return channel->is_wanted();
  };
  return channels_.status->is_wanted() || channels_.joints->is_wanted() ||
         std::ranges::any_of(channels_.axis_status, is_wanted) ||
         std::ranges::any_of(channels_.axis_trace, is_wanted);
}

bool BenchFeed::begin() {
  const auto record = roster_.find(bench_.info.number);
  if (!record || !record->is_alive || !follower_.open(Clock::now())) return false;
  newest_.reset();
  next_rating_ = 0;
  choose_traces();
  return true;
}

/// Takes ticks until `until`, or until there is something to publish before that.
void BenchFeed::follow(Clock::time_point until) {
  const Clock::time_point begin = Clock::now();
  while (true) {
    const auto now = Clock::now();
    if (is_urgent_ && now - begin >= kUrgentPeriod) return;
    const auto left = std::chrono::ceil<milliseconds>(until - now);
    auto observation = follower_.next(std::clamp(left, milliseconds(0), kIdle));
    if (observation) {
      take(std::move(*observation));
      const bool is_full = !traced_.empty() && traces_[traced_[0]].ticks.size() >= kLongestTrace;
      if (is_full) return;
      continue;
    }
    if (!follower_.is_open() || left.count() <= 0) return;
  }
}

void BenchFeed::take(client::Observation&& observation) {
  ensure(observation.axes.size() == ids_.size(), "an observation has the axes that are followed");
  // Samples missed before the first one were not wanted.
  if (newest_) missed_ += observation.missed;
  trace(observation);
  owners_.note(observation);
  is_urgent_ = is_urgent_ || has_news(observation);
  newest_ = std::move(observation);
  is_new_ = true;
}

bool BenchFeed::has_news(const client::Observation& observation) const {
  for (std::size_t i = 0; i < observation.axes.size(); ++i) {
    if (news_of(observation.axes[i].status) != published_states_[i]) return true;
  }
  return false;
}

void BenchFeed::trace(const client::Observation& observation) {
  for (const std::size_t place : traced_) {
    traces_[place].ticks.push_back(observation.tick);
    traces_[place].status.push_back(observation.axes[place].status);
  }
}

void BenchFeed::choose_traces() {
  traced_.clear();
  for (std::size_t i = 0; i < channels_.axis_trace.size(); ++i) {
    traces_[i].ticks.clear();
    traces_[i].status.clear();
    if (channels_.axis_trace[i]->is_wanted()) traced_.push_back(i);
  }
}

/// While time stands still no tick arrives, but a new subscriber needs a message.
void BenchFeed::observe_once() {
  auto observation = session_.observe(ids_);
  if (!observation) return;
  ensure(observation->axes.size() == ids_.size(), "an observation has the axes that are followed");
  owners_.note(*observation);
  newest_ = std::move(*observation);
  is_new_ = true;
}

void BenchFeed::publish_axes() {
  if (!follower_.is_open()) return;
  const auto wants_now = [](const ChannelPointer& channel) {
    return channel->has_new_receiver.load();
  };
  const bool is_first = wants_now(channels_.status) || wants_now(channels_.joints) ||
                        std::ranges::any_of(channels_.axis_status, wants_now);
  if (is_first && !newest_) observe_once();
  if (!newest_ || (!is_new_ && !is_first)) return;
  Batch batch{.bench = newest_->axes.front().id.bench, .time = time_of(newest_->tick)};
  add_axes(batch);
  add_traces(batch);
  for (std::size_t i = 0; i < newest_->axes.size(); ++i) {
    published_states_[i] = news_of(newest_->axes[i].status);
  }
  is_new_ = false;
  is_urgent_ = false;
  news_.publish(std::move(batch));
}

void BenchFeed::add_axes(Batch& batch) {
  const auto wants = [this](const ChannelPointer& channel) {
    // The flag is read first: a later subscription sets it again.
    const bool is_first = channel->has_new_receiver.exchange(false);
    return channel->is_wanted() && (is_new_ || is_first);
  };
  if (wants(channels_.status)) {
    batch.messages.push_back(
        {channels_.status, share(bridge::encode_bench_status(*newest_, batch.time))});
  }
  if (wants(channels_.joints)) {
    refresh_joints(Clock::now());
    batch.messages.push_back(
        {channels_.joints, share(bridge::encode_joint_states(*newest_, joints_, batch.time))});
  }
  for (std::size_t i = 0; i < channels_.axis_status.size(); ++i) {
    if (!wants(channels_.axis_status[i])) continue;
    batch.messages.push_back({channels_.axis_status[i],
                              share(bridge::encode_axis_status(newest_->axes[i], batch.time))});
  }
}

/// Reads the ratings of all axes before the first message, so that it contains all efforts. Ratings
/// hardly ever change, so later calls read one axis each.
void BenchFeed::refresh_joints(Clock::time_point now) {
  if (next_rating_ != 0 && now < rating_due_) return;
  rating_due_ = now + kRatingPeriod;
  const std::size_t count = next_rating_ < joints_.size() ? joints_.size() : 1;
  for (std::size_t i = 0; i < count; ++i) read_rating(next_rating_++ % joints_.size());
}

void BenchFeed::read_rating(std::size_t place) {
  const auto axis = session_.axis(to_string(ids_[place]));
  if (!axis) return;
  const auto effort = read_effort_per_mille(*axis, bench_.info.axes[place].unit);
  if (effort) joints_[place].scale.effort_per_mille = *effort;
}

void BenchFeed::add_traces(Batch& batch) {
  for (const std::size_t place : traced_) {
    bridge::Trace& trace = traces_[place];
    if (trace.ticks.empty()) continue;
    trace.missed = missed_;
    batch.messages.push_back(
        {channels_.axis_trace[place], share(bridge::encode_axis_trace(trace, batch.time))});
  }
  choose_traces();
}

void BenchFeed::publish_description() {
  const bool is_first = channels_.description->has_new_receiver.exchange(false);
  const bool is_renewed = is_renewed_.exchange(false);
  if (!channels_.description->is_wanted() || !(is_first || is_renewed)) return;
  auto record = roster_.find(bench_.info.number);
  if (!record) return;
  const KnownBench known{std::move(record->info), bench_.topic, bench_.axis_names};
  send(channels_.description, time_of(known.info.tick), description_text(known));
}

/// Called even while the bench is silent. Without receivers, only publishes the time, which is the
/// clock of the clients' tools.
void BenchFeed::publish_state(Clock::time_point now) {
  const bool is_first = channels_.state->has_new_receiver.exchange(false);
  if (!is_first && now < next_state_) return;
  next_state_ = now + kStatePeriod;
  roster_.refresh(session_.present_benches(), now);
  const auto record = roster_.find(bench_.info.number);
  if (!record) return;
  const std::uint64_t time = time_of(record->info.tick);
  if (!channels_.state->is_wanted()) {
    return news_.publish({.bench = bench_.info.number, .time = time});
  }
  const auto age = std::chrono::duration_cast<milliseconds>(now - record->newest_sample);
  send(channels_.state, time,
       state_text(record->info, time, age, record->is_alive, owner_names(), owners_.takings()));
}

/// Does not wait: a name that is not known yet follows in a later message.
OwnerNames BenchFeed::owner_names() const {
  OwnerNames names;
  for (const std::uint64_t owner : owners_.sessions()) {
    if (auto name = session_.known_name(bench_.info.number, owner)) {
      names.emplace(owner, std::move(*name));
    }
  }
  return names;
}

std::uint64_t BenchFeed::time_of(std::uint64_t tick) const {
  return tick * static_cast<std::uint64_t>(std::chrono::nanoseconds(bench_.info.period).count());
}

}  // namespace vdrive::gateway
