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

/// How the name of the participant of a service begins; its bench follows.
constexpr std::string_view kService = "vdrived ";

/// A refused datagram is logged at most once a second, with its sender.
wire::NetworkSettings of_a_service(const WireSettings& settings) {
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

/// @return the number of the bench that a sample is about, or nothing.
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
      participant_(wire::make_participant(of_a_service(settings),
                                          std::string(kService) + std::to_string(settings.bench))),
      publications_(wire::kTopics.size()),
      status_(region.ring(Lane::status)),
      replies_(region.ring(Lane::replies)),
      reports_(region.ring(Lane::reports)),
      arrivals_(region.ring(Lane::arrivals), region.ring(Lane::turned_away)),
      notices_(region.ring(Lane::notices)),
      arrivals_bell_(control_.arrivals_bell) {
  // The engine reports anew to each wire, and old status is of no use. Answers stay: clients wait
  // for them.
  status_.clear();
  reports_.clear();
  control_.source = participant_->source();
  for (std::size_t number = 0; number < wire::kTopics.size(); ++number) {
    const auto topic = static_cast<TopicId>(number);
    const bool is_optional = topic == Topic<msg::BenchSession>::kId;  // of exchange_names
    if (wire::kTopics[number].publisher == wire::Publisher::service && !is_optional) publish(topic);
  }
  // Only where a second bench could have this number: if a thousand benches share a bus, each would
  // hear all the others.
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

/// A bench whose permissions are from before these topics runs, and knows nobody's name. The
/// service of a bench publishes no name that it did not receive.
void WireProgram::exchange_names() {
  try {
    publish(Topic<msg::BenchSession>::kId);
    subscribe(Topic<msg::SessionName>::kId, Lane::notices);
  } catch (const wire::NetworkError& refused) {
    if (is_open_) throw;
    log_warning(R"(names=off bench={} text="{}")", bench_, refused.what());
  }
}

/// Nothing arrives any more before the rings go.
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

/// Behind the state of another service stands where that service runs, as far as it says it.
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
  // A client that may not know all benches yet searches for longer than a state takes, and each
  // additional state goes to every reader. One that knows them all waits for the state only.
  if (topic == Topic<msg::BenchState>::kId && !participant_->presence().may_miss_some()) {
    control_.is_state_wanted = true;
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

/// A round has an end also while the engine fills the lane as fast as it is emptied: between rounds
/// the calling thread counts its progress and serves the other lanes.
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

/// @return false when its reader is not known yet.
bool WireProgram::try_send(const RecordHead& head, std::span<const std::byte> bytes) {
  const auto topic = wire::topic_numbered(head.topic);
  wire::SampleWriter* const publication =
      topic ? publications_[static_cast<std::size_t>(*topic)].get() : nullptr;
  if (publication == nullptr) {  // the engine wrote what it never writes
    control_.not_sent.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
  if ((head.flags & RecordHead::kForOne) != 0 && !publication->matches().contains(head.party))
    return false;
  auto& counter = publication->write(bytes) ? control_.sent : control_.not_sent;
  counter.fetch_add(1, std::memory_order_relaxed);
  return true;
}

/// A client that never reads, or that has gone, fills its own places and those of no other client.
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
    log_warning("reply=dropped bench={} participant={} suppressed={} text=\"it has no reader\"",
                bench_, party, *suppressed);
  }
}

bool WireProgram::wait_for_readers(std::chrono::milliseconds timeout) {
  // A reader that learns first that the participant has ended drops a reply that it has not read.
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
