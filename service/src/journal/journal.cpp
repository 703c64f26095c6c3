// SPDX-License-Identifier: Apache-2.0
#include "journal/journal.hpp"

#include "base/event_codes.hpp"
#include "base/file_lock.hpp"
#include "base/log.hpp"
#include "base/system_failure.hpp"
#include "configuration/configuration_file.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/text.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kWriterNap = 2ms;  // the queue holds half a second of the shortest ticks
constexpr auto kRoomNap = 50us;
constexpr auto kFlushInterval = 1s;
// Axes per row on a bench with more axes than a slot has rows.
constexpr std::size_t kAxesPerLargeRow = 64;
constexpr int kMode = 0644;

/// Owns a file descriptor.
class File {
 public:
  File(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}

  ~File() { unlock_and_close(descriptor_); }

  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(std::span<const std::byte> bytes) const {
    while (!bytes.empty()) {
      const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno != EINTR) fail(name_);
      bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    }
  }

  /// False for a device or a pipe: they cannot contain an earlier journal.
  [[nodiscard]] bool holds_something() const { return is_regular() && status().st_size > 0; }

  /// The lock belongs to the file, whatever name it was opened under. A device takes any number of
  /// journals. @return false if another program holds the lock.
  [[nodiscard]] bool try_lock() const { return !is_regular() || try_lock_file(descriptor_); }

  /// @return a description of the program that holds the lock.
  [[nodiscard]] std::string holder() const { return holder_of_lock(descriptor_); }

 private:
  [[nodiscard]] struct stat status() const {
    struct stat status {};

    if (::fstat(descriptor_, &status) != 0) fail(name_);
    return status;
  }

  [[nodiscard]] bool is_regular() const { return S_ISREG(status().st_mode); }

  int descriptor_;
  std::string name_;
};

}  // namespace

JournalSink open_journal(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, kMode);  // NOLINT
  if (descriptor < 0) {
    throw ConfigurationError("journal " + escaped(file.string(), kShownOfMessage) +
                             ": cannot be written: " + std::generic_category().message(errno));
  }
  auto opened = std::make_shared<File>(descriptor, file.string());
  if (!opened->try_lock()) {
    throw ConfigurationError("journal " + escaped(file.string(), kShownOfMessage) +
                             ": is being written by another bench, " + opened->holder());
  }
  if (opened->holds_something()) {
    throw ConfigurationError("journal " + escaped(file.string(), kShownOfMessage) +
                             ": is not empty; an existing file is not overwritten");
  }
  return [opened](std::span<const std::byte> bytes) {
    opened->write(bytes);
  };
}

Journal::Journal(const Configuration& configuration, JournalSink sink, Counters& counters)
    : sink_(std::move(sink)),
      counters_(counters),
      may_wait_(configuration.clock != ClockMode::realtime),
      ring_(kSlots) {
  const std::size_t axes = configuration.axes.size();
  start_.layout = AxisBank::snapshot_layout();
  start_.axes_per_row = axes <= kMostRows ? 1 : kAxesPerLargeRow;
  start_.rows = static_cast<std::uint32_t>((axes + start_.axes_per_row - 1) / start_.axes_per_row);
  start_.version = VDRIVE_VERSION;
  start_.configuration = to_yaml(configuration);
}

Journal::~Journal() {
  close();
}

void Journal::begin(const AxisBank& bank, std::uint64_t tick) {
  writer_.emplace(sink_, start_);
  writer_->write(JournalSnapshot{
      .cause = JournalSnapshot::Cause::start, .tick = tick, .state = bank.snapshot().bytes()});
  if (!may_wait_) spare_ = std::make_shared<AxisBank::Snapshot>(bank.snapshot());
  ended_ = false;
  thread_ = std::thread([this] {
    write();
  });
}

void Journal::close() noexcept {
  if (std::exchange(ended_, true)) return;
  if (slot_ != nullptr) push(Slot::End::none, 0);
  stop_.store(true, std::memory_order_release);
  thread_.join();
}

// ---- the thread that steps the bank ----------------------------------------------------------

bool Journal::is_recording() const noexcept {
  return !ended_ && error_.load(std::memory_order_relaxed) == 0;
}

/// @return the slot to fill, or nullptr if there is none and the clock cannot wait.
Journal::Slot* Journal::open_slot() noexcept {
  while (slot_ == nullptr) {
    slot_ = ring_.free_slot();
    if (slot_ != nullptr) {
      slot_->entry_count = 0;
    } else if (may_wait_ && is_recording()) {
      std::this_thread::sleep_for(kRoomNap);
    } else {
      break;
    }
  }
  return slot_;
}

void Journal::push(Slot::End end, std::uint64_t tick) noexcept {
  ensure(slot_ != nullptr, "an open slot ends once");
  slot_->end = end;
  slot_->tick = tick;
  slot_ = nullptr;
  ring_.push();
}

void Journal::record(const JournalEntry& entry, const JournalAuthor& author) noexcept {
  if (author_ != author) {
    put(author);
    author_ = author;
  }
  put(entry);
}

void Journal::put(const JournalEntry& entry) noexcept {
  if (!is_recording() || losing_) return;
  if (slot_ != nullptr && slot_->entry_count == Slot::kEntries) push(Slot::End::none, 0);
  if (Slot* const slot = open_slot(); slot != nullptr) {
    slot->entries[slot->entry_count] = entry;
    ++slot->entry_count;
  } else {
    start_losing();
  }
}

void Journal::record_restore(std::shared_ptr<const AxisBank::Snapshot> snapshot,
                             std::uint64_t tick) noexcept {
  if (!is_recording() || losing_) return;
  if (Slot* const slot = open_slot(); slot != nullptr) {
    slot->snapshot = std::move(snapshot);
    push(Slot::End::restored, tick);
  } else {
    start_losing();
  }
}

void Journal::record_tick(const AxisBank& bank, std::uint64_t tick) noexcept {
  if (!is_recording()) {
    counters_.journal_losses.add(ended_ ? 0 : 1);
    return;
  }
  if (losing_) {
    lose_tick(bank, tick);
  } else if (Slot* const slot = open_slot(); slot != nullptr) {
    slot->digest = digest_of(bank.statuses(), start_.axes_per_row, slot->rows);
    push(Slot::End::tick, tick);
  } else {
    start_losing();
    if (losing_) lose_tick(bank, tick);
  }
}

void Journal::start_losing() noexcept {
  if (!is_recording()) {
    return;  // recording ended while this thread waited for room
  }
  losing_ = true;
  reported_loss_ = false;
  lost_ = 0;
}

/// Resumes the journal after this tick once half of the queue is free. Resuming earlier would
/// burden a slow disk with one snapshot after another.
void Journal::lose_tick(const AxisBank& bank, std::uint64_t tick) noexcept {
  ++lost_;
  counters_.journal_losses.add();
  if (ring_.size() > ring_.capacity() / 2 || spare_used_.load(std::memory_order_acquire)) return;
  Slot* const slot = open_slot();
  if (slot == nullptr) return;
  bank.save(*spare_);
  spare_used_.store(true, std::memory_order_relaxed);  // push() publishes it to the writer
  slot->snapshot = spare_;
  slot->lost = lost_;
  push(Slot::End::resumed, tick);
  losing_ = false;
  author_.reset();
  resumed_after_ += lost_;
}

std::optional<JournalNews> Journal::news() noexcept {
  if (!std::exchange(reported_loss_, true)) return JournalNews{.code = JournalCode::kLosing};
  if (resumed_after_ != 0) {
    return JournalNews{.code = JournalCode::kResumed,
                       .detail = Count{std::exchange(resumed_after_, 0)}};
  }
  const int error = error_.load(std::memory_order_relaxed);
  if (error != 0 && !std::exchange(reported_end_, true)) {
    return JournalNews{.code = JournalCode::kEnded, .detail = SystemError{error}};
  }
  return std::nullopt;
}

// ---- the thread that writes ------------------------------------------------------------------

void Journal::write() noexcept {
  try {
    auto next_flush = Clock::now() + kFlushInterval;
    for (bool last = false; !last;) {
      last = stop_.load(std::memory_order_acquire);
      if (!write_waiting() && !last) std::this_thread::sleep_for(kWriterNap);
      if (Clock::now() >= next_flush) {
        writer_->flush();
        next_flush = Clock::now() + kFlushInterval;
      }
    }
    writer_->end();
  } catch (const std::system_error& error) {
    error_.store(error.code().value() == 0 ? EIO : error.code().value());
    log_error("the journal cannot be written: {}; recording has stopped", error.what());
  } catch (const std::exception& error) {
    error_.store(ENOMEM);
    log_error("the journal cannot be written: {}; recording has stopped", error.what());
  }
}

/// @return whether there was anything to write.
bool Journal::write_waiting() {
  bool any = false;
  while (Slot* const slot = ring_.front()) {
    write_slot(*slot);
    ring_.pop();
    any = true;
  }
  return any;
}

void Journal::write_slot(Slot& slot) {
  const bool has_state = slot.end == Slot::End::restored || slot.end == Slot::End::resumed;
  ensure(!has_state || slot.snapshot != nullptr, "a slot that continues elsewhere has a state");
  for (std::size_t position = 0; position < slot.entry_count; ++position) {
    std::visit(
        [this](const auto& entry) {
          writer_->write(entry);
        },
        slot.entries[position]);
  }
  switch (slot.end) {
    case Slot::End::none:
      break;
    case Slot::End::tick:
      writer_->write_tick(slot.tick, slot.digest, std::span(slot.rows).first(start_.rows));
      counters_.journal_ticks.add();
      break;
    case Slot::End::restored:
      writer_->write(JournalSnapshot{.cause = JournalSnapshot::Cause::restored,
                                     .tick = slot.tick,
                                     .state = slot.snapshot->bytes()});
      slot.snapshot.reset();
      break;
    case Slot::End::resumed:
      writer_->write(JournalSnapshot{.cause = JournalSnapshot::Cause::resumed,
                                     .tick = slot.tick,
                                     .lost = slot.lost,
                                     .state = slot.snapshot->bytes()});
      slot.snapshot.reset();
      spare_used_.store(false, std::memory_order_release);
      break;
  }
}

}  // namespace vdrive::service
