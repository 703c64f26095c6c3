// SPDX-License-Identifier: Apache-2.0
#include "dds/writer.hpp"

#include "dds/bytes_type.hpp"
#include "dds/quality.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <utility>

namespace vdrive::wire {

namespace {

// Asking whether everything is acknowledged takes 60 us if it is not, so only a writer that has
// been idle for this long asks.
constexpr std::chrono::milliseconds kRest{2};
// A writer that is never idle waits for the acknowledgements after this many writes, long before a
// gap is so wide that a guard refuses it. The wait is longer than the heartbeat period.
constexpr std::uint32_t kWritesBeforeWait = 8'192;
constexpr std::chrono::milliseconds kLongestWait{20};

}  // namespace

DdsWriter::DdsWriter(DdsEntities& parent, TopicId topic, Observer observer)
    : DdsWriter(parent, std::string(kTopicPrefix) + std::string(traits_of(topic).name),
                dds::TypeSupport(new BytesType(topic)), writer_qos(traits_of(topic)),
                std::move(observer)) {}

DdsWriter::DdsWriter(DdsEntities& parent, const std::string& name, const dds::TypeSupport& type,
                     const dds::DataWriterQos& qos, Observer observer)
    : entities_(parent), publisher_(parent.publisher), observer_(std::move(observer)) {
  if (parent.permissions && !parent.permissions->may_publish(name)) {
    throw NotPermitted("the permissions of this identity do not allow publishing " + name);
  }
  auto* const topic = parent.topic(name, type);
  {
    const std::scoped_lock lock(parent.changing);
    writer_ =
        publisher_->create_datawriter(topic, qos, this, dds::StatusMask::publication_matched());
  }
  if (writer_ == nullptr) throw NetworkError("DDS could not create a writer on topic " + name);
  forgets_ = qos.reliability().kind == dds::RELIABLE_RELIABILITY_QOS &&
             qos.durability().kind == dds::VOLATILE_DURABILITY_QOS;
}

DdsWriter::~DdsWriter() {
  // Empty the history first. When Fast DDS 2.9 deletes a writer (RTPSWriter::deinit), it frees the
  // unacknowledged samples in the history while the heartbeat timer still runs and reads their
  // numbers there. The timer may then count a gap of up to 2^63 samples, and the deletion never
  // ends. Fast DDS 3.1 holds the lock of the writer during the deletion.
  std::size_t removed = 0;
  const auto deletion = entities_.erase();
  writer_->clear_history(&removed);
  publisher_->delete_datawriter(writer_);
}

bool DdsWriter::write(std::span<const std::byte> sample) noexcept {
  try {
    std::unique_lock lock(writing_, std::defer_lock);
    if (forgets_) {
      lock.lock();
      remove_acknowledged();
    }
    BytesSample data{.bytes = sample};
    return write_to(*writer_, &data);
  } catch (...) {
    return false;
  }
}

/// Fast DDS 2.9 and 3.1: the library removes a sample when all readers have acknowledged it. But
/// while a reader that has just joined has not answered, the library only marks such samples as
/// removed and then keeps them for good (StatefulWriter::check_acked_status). Every later reader
/// receives, with each heartbeat, a gap of all numbers since the oldest of them and processes it
/// number by number; a guard refuses wide gaps. Nobody needs samples that all have acknowledged, so
/// remove them here.
void DdsWriter::remove_acknowledged() {
  const auto spoken = joined_.load(std::memory_order_relaxed) + kLongestSilence;
  if (removed_ >= spoken) return;
  const auto now = Clock::now();
  const bool has_rested = now - std::exchange(written_, now) >= kRest;
  const bool waits = ++writes_ >= kWritesBeforeWait && now >= spoken;
  if (!has_rested && !waits) return;
  if (waits) writes_ = 0;
  if (!wait_for_acknowledged(waits ? kLongestWait : std::chrono::milliseconds{0})) return;
  std::size_t count = 0;
  writer_->clear_history(&count);
  writes_ = 0;
  removed_ = now;
}

bool DdsWriter::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  constexpr std::int64_t kMillisecondsPerSecond = 1'000;
  constexpr std::uint32_t kNanosecondsPerMillisecond = 1'000'000;
  const auto milliseconds = timeout.count();
  return is_ok(writer_->wait_for_acknowledgments(
      {static_cast<std::int32_t>(milliseconds / kMillisecondsPerSecond),
       static_cast<std::uint32_t>(milliseconds % kMillisecondsPerSecond) *
           kNanosecondsPerMillisecond}));
}

void DdsWriter::on_publication_matched(dds::DataWriter* /*writer*/,
                                       const dds::PublicationMatchedStatus& status) {
  const std::lock_guard lock(observing_);
  const EndpointId reader = endpoint_of(status.last_subscription_handle);
  if (status.current_count_change > 0) {
    joined_.store(Clock::now(), std::memory_order_relaxed);
    matches_.add(reader);
  } else {
    matches_.remove(reader);
  }
  if (observer_) observer_(matches_.sources());
}

}  // namespace vdrive::wire
