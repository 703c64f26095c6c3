// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/random_cases.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::simulation {

using test::Random;

/// The messages of a client.
using ClientMessage = std::variant<msg::CommandFrame, msg::Request>;

inline constexpr std::int64_t kMicrosecond = 1'000;  ///< times are in ns
inline constexpr std::int64_t kMillisecond = 1'000'000;

/// The treatment of messages by a network.
struct NetworkHabits {
  std::uint64_t drops = 0;    ///< per mille
  std::uint64_t doubles = 0;  ///< per mille
  std::uint64_t delays = 0;   ///< per mille that take up to `longest_delay`
  std::int64_t longest_delay = 300 * kMillisecond;
  bool keeps_order = false;  ///< of one sender
};

/// Messages in transit, to the bench or back: dropped, duplicated, late, out of order.
template <typename Message>
class Network {
 public:
  static constexpr std::size_t kSenders = 4;

  Network(const NetworkHabits& habits, std::uint64_t seed) : habits_(habits), random_(seed) {}

  void send(std::size_t sender, Message message, std::int64_t now) {
    if (random_.per_mille(habits_.drops)) return;
    if (random_.per_mille(habits_.doubles)) put(sender, message, now);
    put(sender, std::move(message), now);
  }

  /// Holds back the messages of this sender until `until`: its process or its host is paused.
  void hold_back(std::size_t sender, std::int64_t until) {
    held_until_[sender] = std::max(held_until_[sender], until);
    for (auto& entry : entries_) {
      if (entry.sender == sender) entry.time = std::max(entry.time, until);
    }
    std::make_heap(entries_.begin(), entries_.end(), later);
  }

  [[nodiscard]] bool has_arrived(std::int64_t now) const {
    return !entries_.empty() && entries_.front().time <= now;
  }

  /// @return the message that arrived first, with its sender.
  std::pair<std::size_t, Message> take() {
    std::pop_heap(entries_.begin(), entries_.end(), later);
    std::pair<std::size_t, Message> taken{entries_.back().sender,
                                          std::move(entries_.back().message)};
    entries_.pop_back();
    return taken;
  }

 private:
  struct Entry {
    std::int64_t time = 0;
    std::uint64_t serial = 0;
    std::size_t sender = 0;
    Message message;
  };

  static bool later(const Entry& a, const Entry& b) {
    return std::pair(a.time, a.serial) > std::pair(b.time, b.serial);
  }

  void put(std::size_t sender, Message message, std::int64_t now) {
    std::int64_t time = now + random_.between(50 * kMicrosecond, 3 * kMillisecond);
    if (random_.per_mille(habits_.delays)) time += random_.between(0, habits_.longest_delay);
    time = std::max(time, held_until_[sender]);
    if (habits_.keeps_order) {
      time = std::max(time, last_[sender]);
      last_[sender] = time;
    }
    entries_.push_back({time, ++serial_, sender, std::move(message)});
    std::push_heap(entries_.begin(), entries_.end(), later);
  }

  NetworkHabits habits_;
  Random random_;
  std::vector<Entry> entries_;
  std::uint64_t serial_ = 0;
  std::array<std::int64_t, kSenders> held_until_{};
  std::array<std::int64_t, kSenders> last_{};
};

}  // namespace vdrive::simulation
