// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/event_record.hpp"
#include "base/reason.hpp"
#include "base/ring.hpp"
#include "base/window.hpp"
#include "seam/byte_ring.hpp"
#include "seam/stored_replies.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/reply.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::service {

/// A command frame or a request from a client.
struct Arrival {
  enum class Kind : std::uint8_t { command_frame, request };

  Kind kind = Kind::command_frame;
  Reason refusal;  ///< REASON_TOO_MANY_...: only the head of the message is present
  wire::Source source;
  msg::CommandFrame frame;
  msg::Request request;
};

/// An arrival that found the inbox full. It is answered with REASON_QUEUE_FULL.
struct TurnedAway {
  Arrival::Kind kind = Arrival::Kind::command_frame;
  wire::Source source;
  std::uint64_t client = 0;
  std::uint64_t request_id = 0;
  std::uint64_t session = 0;
  std::uint64_t sequence_number = 0;
};

/// The producer's end of the inbox of a bench: samples from clients, unchanged and in order of
/// arrival. For one thread at a time.
class InboxWriter {
 public:
  /// The maximum number of waiting arrivals; fewer if they are large.
  static constexpr std::size_t kCapacity = 1024;

  InboxWriter(ByteRing arrivals, ByteRing turned_away) noexcept
      : arrivals_(arrivals), turned_away_(turned_away) {}

  /// Takes a sample of `command` or `request`. If it does not fit, keeps its beginning, which the
  /// refusal needs. @return whether it fitted.
  bool put(wire::TopicId topic, std::span<const std::byte> sample,
           const wire::Source& source) noexcept;

 private:
  ByteRing arrivals_;
  ByteRing turned_away_;
};

/// The engine's end of the inbox: decodes and validates arrivals. Belongs to the thread that steps
/// the bank, except `next_turned_away`, which belongs to the thread that answers.
class Inbox {
 public:
  Inbox(std::uint32_t bench, ByteRing arrivals, ByteRing turned_away, Counters& counters);

  /// @return the oldest arrival for this bench, or nullptr; its content may be moved out. Samples
  ///         that cannot be decoded are dropped and counted.
  [[nodiscard]] Arrival* front();

  /// Drops the arrival of `front`.
  void pop() noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return arrivals_.size(); }

  /// @return whether at most half of the room is taken. Any thread.
  [[nodiscard]] bool has_room() const noexcept {
    return arrivals_.size() <= InboxWriter::kCapacity / 2 &&
           arrivals_.bytes() <= arrivals_.capacity() / 2;
  }

  /// @return the oldest arrival that did not fit, or nullopt.
  std::optional<TurnedAway> next_turned_away();

  /// @return whether `next_turned_away` would return one. Any thread.
  [[nodiscard]] bool has_turned_away() const noexcept { return turned_away_.size() > 0; }

 private:
  [[nodiscard]] bool decode(const ByteRing::Record& record);

  std::uint32_t bench_;
  Counters& counters_;
  ByteRing arrivals_;
  ByteRing turned_away_;
  wire::CommandDecoder decoder_;
  wire::CommandDecoder head_decoder_;  ///< for `next_turned_away`, in another thread
  Arrival arrival_;
  bool is_decoded_ = false;
};

/// A page of a black box window. The thread that sends the page computes it.
struct WindowPage {
  Window window;                  ///< held until the page is computed
  std::vector<std::size_t> axes;  ///< requested axes: indexes on the bench
  std::uint64_t place = 0;        ///< the number of items on the previous pages
};

/// An answer and its receiver.
struct OutgoingReply {
  wire::Source destination;
  msg::Reply reply;                    ///< without its statuses
  std::vector<wire::ShownAxis> axes;   ///< axes whose status it contains
  std::unique_ptr<WindowPage> page{};  ///< still to be computed and added
};

/// The status of all axes after one tick.
struct StatusImage {
  std::uint64_t tick = 0;
  std::uint64_t skipped = 0;  ///< ticks that the number had jumped over by then
  bool repeated = false;      ///< nothing moved since an earlier image of the same tick
  std::vector<AxisStatus> status;
  std::vector<wire::Ownership> owners;
};

/// All output of the thread that steps the bank. An overflow of a queue is counted, and reported by
/// an event as soon as there is room for one.
struct Outbox {
  static constexpr std::size_t kReplies = 256;
  /// The maximum number of frames that wait for a later tick. All of them may be dropped, and
  /// answered, at the same time.
  static constexpr std::size_t kPendingFrames = 1024;
  static constexpr std::size_t kCommandReplies = kReplies + kPendingFrames;
  static constexpr std::size_t kEvents = 8192;
  static constexpr std::size_t kParameters = 256;

  /// @param axes the number of axes in a status image
  /// @param images the maximum number of waiting status images
  explicit Outbox(std::size_t axes, std::size_t images = 16);

  Ring<StoredCommandReply> command_replies;
  Ring<OutgoingReply> replies;
  Ring<EventRecord> events;
  Ring<msg::AxisParameters> parameters;
  Ring<StatusImage> status;

  [[nodiscard]] std::size_t size() const noexcept;

  /// @return whether anything other than status is waiting.
  [[nodiscard]] bool has_news() const noexcept;
};

}  // namespace vdrive::service
