// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/log.hpp"
#include "seam/lane_sender.hpp"
#include "seam/queues.hpp"
#include "seam/wire_region.hpp"
#include "vdrive/token_bucket.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/sample_writer.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace vdrive::service {

/// The wire of a bench: passes samples between the rings of a region and the DDS topics. It decodes
/// no messages and keeps no state of the bench, so another wire can replace it at any time. It runs
/// in the receive threads of the library and in the callers of `drain`.
class WireProgram final : public LaneSender {
 public:
  /// How long an answer waits for its reader.
  static constexpr std::chrono::seconds kLongestWait{1};
  /// The maximum number of answers that wait for their readers, in all and for one reader.
  static constexpr std::size_t kMostHeld = 256;
  static constexpr std::size_t kMostHeldForOne = 16;

  /// Joins the domain. Drops the output of the engine for an earlier wire, except answers.
  /// @throws wire::NetworkError
  WireProgram(const WireRegion& region, const WireSettings& settings);
  ~WireProgram() override;
  WireProgram(const WireProgram&) = delete;
  WireProgram& operator=(const WireProgram&) = delete;

  /// The limits of one call of `drain`; the record that exceeds the number of bytes is still sent.
  static constexpr std::size_t kMostInOneRound = 256;
  static constexpr std::size_t kMostBytesInOneRound = std::size_t{512} * 1'024;

  bool drain(Lane lane) override;

  [[nodiscard]] bool is_holding() const noexcept override { return !held_.empty(); }

  /// Waits until all readers have the description of the bench and the replies.
  /// @return false on timeout
  bool wait_for_readers(std::chrono::milliseconds timeout);

  [[nodiscard]] wire::Participant& participant() noexcept { return *participant_; }

  /// From now on, samples from `source` are probes: they are counted and not passed on.
  void expect_probes_from(const wire::Source& source);

  [[nodiscard]] std::uint64_t probes_received() const noexcept { return probes_received_; }

  /// @return the number of datagrams dropped by the guard of the participant.
  [[nodiscard]] std::uint64_t datagrams_dropped() const {
    return participant_->guard_counts().all_refused();
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// An answer whose reader has not been discovered yet.
  struct Held {
    RecordHead head;
    std::vector<std::byte> bytes;
    Clock::time_point deadline;
  };

  /// Puts the samples of a topic into a ring.
  struct LaneSubscription {
    wire::TopicId topic{};
    Lane lane = Lane::arrivals;
    std::vector<std::byte> sample;  ///< between the two calls of the library; keeps its capacity
    std::unique_ptr<wire::SampleReader> subscription;
  };

  void show(wire::TopicId topic, const std::vector<wire::Source>& readers);
  void publish(wire::TopicId topic);
  void subscribe(wire::TopicId topic, Lane lane);
  void exchange_names();
  void deliver(LaneSubscription& incoming, const wire::Source& source);
  void put_notice(const LaneSubscription& incoming, const wire::Source& source);
  void send(const ByteRing::Record& record);
  [[nodiscard]] bool try_send(const RecordHead& head, std::span<const std::byte> bytes);
  void hold(const ByteRing::Record& record);
  void retry();
  void drop(const RecordHead& head);

  WireControl& control_;
  std::uint32_t bench_;
  bool is_open_;        ///< open mode: there are no permissions
  std::mutex showing_;  ///< several threads of the library report matches
  std::unique_ptr<wire::Participant> participant_;
  std::vector<std::unique_ptr<wire::SampleWriter>> publications_;  ///< by TopicId; some are nullptr
  ByteRing status_;
  ByteRing replies_;
  ByteRing reports_;
  std::deque<Held> held_;
  std::map<std::array<std::uint8_t, 12>, std::size_t> held_for_;
  CountingLimit drop_log_{kRepeatedLines};
  std::mutex arriving_;  ///< the library has a receive thread for each interface
  InboxWriter arrivals_;
  ByteRing notices_;
  wire::Source prober_;
  std::atomic<std::uint64_t> probes_received_{0};
  Doorbell arrivals_bell_;
  std::vector<std::unique_ptr<LaneSubscription>> subscriptions_;
};

}  // namespace vdrive::service
