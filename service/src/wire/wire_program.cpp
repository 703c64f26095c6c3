// SPDX-License-Identifier: Apache-2.0
#include "wire/wire_program.hpp"

#include "base/log.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/wire/codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdrive::service {
namespace {

using wire::Topic;
using wire::TopicId;

/// Prefix of the participant name of a service, followed by its bench number.
constexpr std::string_view kService = "vdrived ";

/// Logs refused datagrams with their sender, at most one a second.
wire::NetworkSettings service_settings(const WireSettings& settings) {
  wire::NetworkSettings network = settings.network;
  network.role = wire::Role::service;
  network.guard_sink = [bench = settings.bench, mutex = std::make_shared<std::mutex>(),
                        limit = std::make_shared<CountingLimit>(kRepeatedLines)](
                           wire::Refusal refusal, std::string_view sender) {
    const std::lock_guard lock(*mutex);
    if (const auto suppressed = limit->pass(std::chrono::steady_clock::now().time_since_epoch())) {
      log_warning("datagram=refused bench={} sender={} suppressed={} text=\"{}\"", bench, sender,
                  *suppressed, wire::describe(refusal));
    }
  };
  return network;
}

/// @return the bench number in a sample, or nullopt.
std::optional<std::uint32_t> bench_of(std::span<const std::byte> sample, TopicId topic) noexcept {
  const std::size_t offset = wire::traits_of(topic).bench_offset;
  if (sample.size() < offset + sizeof(std::uint32_t)) return std::nullopt;
  std::array<std::byte, sizeof(std::uint32_t)> bytes{};
  std::memcpy(bytes.data(), &sample[offset], bytes.size());
  const bool is_native =
      (sample[1] != std::byte{0}) == (std::endian::native == std::endian::little);
  if (!is_native) std::ranges::reverse(bytes);
  return std::bit_cast<std::uint32_t>(bytes);
}

}  // namespace

WireProgram::WireProgram(const WireRegion& region, const WireSettings& settings)
    : control_(region.control()),
      bench_(settings.bench),
      is_open_(settings.network.security.empty()),
      participant_(wire::make_participant(service_settings(settings),
                                          std::string(kService) + std::to_string(settings.bench))),
      publications_(wire::kTopics.size()),
      status_(region.ring(Lane::status)),
      replies_(region.ring(Lane::replies)),
      reports_(region.ring(Lane::reports)),
      arrivals_(region.ring(Lane::arrivals), region.ring(Lane::turned_away)),
      notices_(region.ring(Lane::notices)),
      arrivals_bell_(control_.arrivals_bell) {
  // The engine repeats its reports to each wire, and old status is of no use. Answers are kept,
  // because clients wait for them.
  status_.clear();
  reports_.clear();
  control_.source = participant_->source();
  for (std::size_t number = 0; number < wire::kTopics.size(); ++number) {
    const auto topic = static_cast<TopicId>(number);
    const bool is_optional = topic == Topic<msg::BenchSession>::kId;  // see exchange_names()
    if (wire::kTopics[number].publisher == wire::Publisher::service && !is_optional) publish(topic);
  }
  // The states of other services are needed only if a second bench could have this number: with a
  // thousand benches on one bus, each would receive the states of all others.
  if (participant_->presence().may_have_double()) {
    subscribe(Topic<msg::BenchState>::kId, Lane::notices);
  }
  subscribe(Topic<msg::CommandFrame>::kId, Lane::arrivals);
  subscribe(Topic<msg::Request>::kId, Lane::arrivals);
  exchange_names();
}

void WireProgram::publish(TopicId topic) {
  const auto number = static_cast<std::size_t>(topic);
  control_.matched[number] = 0;
  publications_[number] =
      participant_->make_writer(topic, [this, topic](const std::vector<wire::Source>& readers) {
        show(topic, readers);
      });
}

/// A bench whose permissions are older than these topics still runs, but without names of sessions.
/// Neither topic is of use without the other: a service only publishes names that it has received.
void WireProgram::exchange_names() {
  try {
    publish(Topic<msg::BenchSession>::kId);
    subscribe(Topic<msg::SessionName>::kId, Lane::notices);
  } catch (const wire::NetworkError& refused) {
    if (is_open_) throw;
    log_warning(R"(names=off bench={} text="{}")", bench_, refused.what());
  }
}

/// Ends the subscriptions first, so that nothing arrives while the rings are destroyed.
WireProgram::~WireProgram() {
  subscriptions_.clear();
}

// ---- what arrives ------------------------------------------------------------------------------

void WireProgram::subscribe(TopicId topic, Lane lane) {
  auto subscription = std::make_unique<LaneSubscription>();
  auto& incoming = *subscription;
  incoming.topic = topic;
  incoming.lane = lane;
  incoming.subscription =
      participant_->make_reader(topic, {.take =
                                            [&incoming](std::span<const std::byte> sample) {
                                              incoming.sample.assign(sample.begin(), sample.end());
                                            },
                                        .deliver =
                                            [this, &incoming](const wire::Source& source) {
                                              deliver(incoming, source);
                                            }});
  subscriptions_.push_back(std::move(subscription));
}

void WireProgram::deliver(LaneSubscription& incoming, const wire::Source& source) {
  const std::lock_guard lock(arriving_);
  if (source == prober_) {
    ++probes_received_;
    return;
  }
  if (source == control_.source || bench_of(incoming.sample, incoming.topic) != bench_) return;
  if (incoming.lane == Lane::notices) {
    put_notice(incoming, source);
    return;
  }
  if (!arrivals_.put(incoming.topic, incoming.sample, source)) {
    control_.overflows.fetch_add(1, std::memory_order_relaxed);
  }
  arrivals_bell_.ring();
}

/// In the ring, the state of another service is followed by the place where that service runs, if
/// it is known.
void WireProgram::put_notice(const LaneSubscription& incoming, const wire::Source& source) {
  constexpr std::size_t kLongestPlace = 128;
  std::string place;
  if (incoming.topic == Topic<msg::BenchState>::kId) {
    for (const wire::OtherParticipant& other : participant_->presence().others(kService)) {
      if (other.source == source) place = other.place.substr(0, kLongestPlace);
    }
  }
  const std::size_t size = incoming.sample.size() + place.size();
  const auto room = notices_.reserve(size);
  if (!room) return;
  const auto end = std::ranges::copy(incoming.sample, room->begin()).out;
  std::ranges::copy(std::as_bytes(std::span(place)), end);
  notices_.commit({.size = static_cast<std::uint32_t>(size),
                   .full_size = static_cast<std::uint32_t>(incoming.sample.size()),
                   .topic = static_cast<std::uint16_t>(incoming.topic),
                   .flags = 0,
                   .party = source});
}

void WireProgram::show(TopicId topic, const std::vector<wire::Source>& readers) {
  control_.matched[static_cast<std::size_t>(topic)].store(
      static_cast<std::uint32_t>(readers.size()), std::memory_order_relaxed);
  // On the network a client searches for longer than the interval of states, because it may not
  // know all benches yet; an additional state would only burden all readers. On the local bus a new
  // client waits for nothing but the state.
  if (topic == Topic<msg::BenchState>::kId && !participant_->presence().may_miss_some()) {
    control_.is_state_requested = true;
  }
  if (topic == Topic<msg::Reply>::kId) {
    const std::lock_guard lock(showing_);
    control_.readers.show(readers);
  }
}

void WireProgram::expect_probes_from(const wire::Source& source) {
  const std::lock_guard lock(arriving_);
  prober_ = source;
  control_.prober = source;
}

// ---- what leaves -------------------------------------------------------------------------------

/// A round is limited even if the engine fills the lane as fast as it is emptied, because between
/// rounds the calling thread counts its progress and serves other lanes.
bool WireProgram::drain(Lane lane) {
  ByteRing& ring = lane == Lane::status ? status_ : lane == Lane::replies ? replies_ : reports_;
  std::size_t sent = 0;
  std::size_t bytes = 0;
  auto record = ring.front();
  for (; record && sent < kMostInOneRound && bytes < kMostBytesInOneRound; record = ring.front()) {
    send(*record);
    bytes += record->bytes.size();
    ++sent;
    ring.pop();
  }
  if (lane == Lane::replies && !held_.empty()) retry();
  return record.has_value();
}

void WireProgram::send(const ByteRing::Record& record) {
  if (!try_send(record.head, record.bytes)) hold(record);
}

/// @return false if the reader has not been discovered yet.
bool WireProgram::try_send(const RecordHead& head, std::span<const std::byte> bytes) {
  const auto topic = wire::topic_numbered(head.topic);
  wire::SampleWriter* const publication =
      topic ? publications_[static_cast<std::size_t>(*topic)].get() : nullptr;
  if (publication == nullptr) {  // the record is invalid
    control_.not_sent.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
  if ((head.flags & RecordHead::kForOne) != 0 && !publication->matches().contains(head.party))
    return false;
  auto& counter = publication->write(bytes) ? control_.sent : control_.not_sent;
  counter.fetch_add(1, std::memory_order_relaxed);
  return true;
}

/// A client that never reads, or is gone, only fills its own places, not those of other clients.
void WireProgram::hold(const ByteRing::Record& record) {
  std::size_t& count = held_for_[record.head.party.participant];
  if (held_.size() >= kMostHeld || count >= kMostHeldForOne) {
    if (count == 0) held_for_.erase(record.head.party.participant);
    drop(record.head);
    return;
  }
  ++count;
  held_.push_back(
      {record.head, {record.bytes.begin(), record.bytes.end()}, Clock::now() + kLongestWait});
}

void WireProgram::retry() {
  const auto now = Clock::now();
  std::erase_if(held_, [&](const Held& held) {
    const bool is_sent = try_send(held.head, held.bytes);
    if (!is_sent && now < held.deadline) return false;
    if (!is_sent) drop(held.head);
    const auto count = held_for_.find(held.head.party.participant);
    if (count != held_for_.end() && --count->second == 0) held_for_.erase(count);
    return true;
  });
}

void WireProgram::drop(const RecordHead& head) {
  control_.undelivered.fetch_add(1, std::memory_order_relaxed);
  if (const auto suppressed = drop_log_.pass(Clock::now().time_since_epoch())) {
    std::string party;
    for (const std::uint8_t byte : head.party.participant) party += fmt::format("{:02x}", byte);
    log_warning(
        "reply=dropped bench={} participant={} suppressed={} text=\"its client did not subscribe "
        "within 1 s, or too many answers were waiting\"",
        bench_, party, *suppressed);
  }
}

bool WireProgram::wait_for_readers(std::chrono::milliseconds timeout) {
  // A reader that learns of the end of the participant drops the replies that it has not read yet.
  constexpr std::array kTopics{Topic<msg::BenchDescription>::kId, Topic<msg::Reply>::kId,
                               Topic<msg::CommandReply>::kId};
  const auto deadline = Clock::now() + timeout;
  return std::ranges::all_of(kTopics, [&](wire::TopicId topic) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    const auto& publication = publications_[static_cast<std::size_t>(topic)];
    ensure(publication != nullptr, "the wire publishes the topics that it waits for");
    return publication->wait_for_acknowledged(std::max(left, std::chrono::milliseconds{0}));
  });
}

}  // namespace vdrive::service
