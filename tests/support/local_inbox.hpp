// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/queues.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

namespace vdrive::test {

/// The memory of two rings, constructed before the inbox that uses it.
struct InboxMemory {
  service::ByteRing arrivals() { return {arrival_positions, as_bytes(arrival_memory)}; }

  service::ByteRing turned_away() { return {turned_away_positions, as_bytes(turned_away_memory)}; }

  static std::span<std::byte> as_bytes(std::vector<std::uint64_t>& memory) {
    return std::as_writable_bytes(std::span(memory));
  }

  service::RingPositions arrival_positions;
  service::RingPositions turned_away_positions;
  std::vector<std::uint64_t> arrival_memory = std::vector<std::uint64_t>(128 * 1'024);
  std::vector<std::uint64_t> turned_away_memory = std::vector<std::uint64_t>(8 * 1'024);
};

/// An inbox in the memory of a test. Messages enter as samples, as they do from the network.
class LocalInbox : private InboxMemory, public service::Inbox {
 public:
  LocalInbox(std::uint32_t bench, service::Counters& counters)
      : service::Inbox(bench, arrivals(), turned_away(), counters),
        writer_(arrivals(), turned_away()),
        counters_of_test_(counters) {}

  /// May be called by any thread.
  template <typename Message>
  void receive(const Message& message, const wire::Source& source) {
    const std::lock_guard lock(producers_);
    sample_.resize(wire::encoded_size(message));
    wire::encode(message, sample_);
    receive_sample(wire::Topic<Message>::kId, sample_, source);
  }

  void receive_sample(wire::TopicId topic, std::span<const std::byte> sample,
                      const wire::Source& source) {
    if (!writer_.put(topic, sample, source)) counters_of_test_.queue_overflows.add();
  }

 private:
  std::mutex producers_;
  service::InboxWriter writer_;
  service::Counters& counters_of_test_;
  std::vector<std::byte> sample_;
};

}  // namespace vdrive::test
