// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/service/counters.hpp"
#include "vdrive/service/pending_frames.hpp"
#include "vdrive/service/ring.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive_messages.h"

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

namespace vdrive::service {

/// What a client sent: a command frame or a request.
struct Arrival {
  enum class Kind : std::uint8_t { command_frame, request };

  Kind kind = Kind::command_frame;
  std::uint32_t refusal = 0;  ///< REASON_TOO_MANY_...: only the head of the message is here
  wire::Source source;
  msg::CommandFrame frame;
  msg::Request request;
};

/// An arrival that found the inbox full; it is answered with REASON_QUEUE_FULL.
struct TurnedAway {
  Arrival::Kind kind = Arrival::Kind::command_frame;
  wire::Source source;
  std::uint64_t client = 0;
  std::uint64_t request_id = 0;
  std::uint64_t session = 0;
  std::uint64_t sequence_number = 0;
};

/// Everything that clients send to one bench, in order of arrival. Filled by the receive threads of
/// the network, emptied by the thread that steps the bank.
class Inbox {
 public:
  static constexpr std::size_t kCapacity = 1024;

  Inbox(std::uint32_t bench, Counters& counters);

  /// Take a message if it is for this bench, of any size. Never block on the consumer.
  void receive(const msg::CommandFrame& frame, const wire::Source& source);
  void receive(const msg::Request& request, const wire::Source& source);

  /// Consumer. See Ring.
  [[nodiscard]] Arrival* front() noexcept { return arrivals_.front(); }

  void pop() noexcept { arrivals_.pop(); }

  [[nodiscard]] std::size_t size() const noexcept { return arrivals_.size(); }

  /// What did not fit, for the thread that answers it.
  [[nodiscard]] Ring<TurnedAway>& turned_away() noexcept { return turned_away_; }

 private:
  void turn_away(const TurnedAway& arrival);

  std::uint32_t bench_;
  Counters& counters_;
  std::mutex producers_;
  Ring<Arrival> arrivals_;
  Ring<TurnedAway> turned_away_;
};

/// An answer and whom it is for.
struct OutgoingReply {
  wire::Source destination;
  msg::Reply reply;
};

/// Something to tell, before it becomes words.
struct EventRecord {
  std::uint32_t kind = 0;  ///< msg::EVENT_...
  std::uint16_t axis = 0;  ///< number on the bench, 0 = the bench
  std::uint64_t session = 0;
  std::uint32_t code = 0;
  std::uint8_t error_register = 0;
  std::uint64_t tick = 0;
  std::uint64_t detail = 0;   ///< a count or number for the text
  std::uint64_t late_by = 0;  ///< of a refused frame: ticks since the one it was meant for
};

/// Status images of all axes after one tick.
struct StatusImage {
  std::uint64_t tick = 0;
  bool repeated = false;  ///< nothing moved since an earlier image of the same tick
  std::vector<AxisStatus> status;
  std::vector<wire::Ownership> owners;
};

/// Everything that leaves the thread that steps the bank. Full queues are counted, and told by an
/// event as soon as there is room for one.
struct Outbox {
  static constexpr std::size_t kReplies = 256;
  /// All frames that wait may be dropped at once.
  static constexpr std::size_t kCommandReplies = kReplies + PendingFrames::kCapacity;
  static constexpr std::size_t kEvents = 8192;
  static constexpr std::size_t kParameters = 256;

  /// @param axes how many axes a status image holds
  explicit Outbox(std::size_t axes);

  Ring<msg::CommandReply> command_replies;
  Ring<OutgoingReply> replies;
  Ring<EventRecord> events;
  Ring<msg::AxisParameters> parameters;
  Ring<StatusImage> status;

  [[nodiscard]] std::size_t size() const noexcept;
};

}  // namespace vdrive::service
