// SPDX-License-Identifier: Apache-2.0
#include "journal/journal_file.hpp"

#include "base/content_check.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <istream>
#include <type_traits>
#include <utility>

namespace vdrive::service {
namespace {

constexpr std::uint64_t kJournalMagic = 0x6C6E726A76726476ULL;  // "vdrvjrnl"
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kFirstVersion = 1;  // without authors and refusals
constexpr std::size_t kChunkSize = 65'536;  // [bytes] of records after which a chunk is written
constexpr std::uint32_t kMostRows = 16'384;

/// Kinds of chunks.
constexpr std::uint32_t kStart = 1;
constexpr std::uint32_t kRecords = 2;
constexpr std::uint32_t kSnapshot = 3;
constexpr std::uint32_t kEnd = 4;

/// Kinds of records other than JournalChange::Kind.
constexpr std::uint8_t kTick = 4;
constexpr std::uint8_t kSameTick = 5;  // no status image changed
constexpr std::uint8_t kJump = 6;
constexpr std::uint8_t kAuthor = 9;
constexpr std::uint8_t kRefusal = 10;

/// Precedes the content of each chunk.
struct ChunkHead {
  std::uint32_t kind = 0;
  std::uint32_t length = 0;  // of the content
  std::uint32_t sequence = 0;
  std::uint32_t head_check = 0;  // of the three above
  std::uint64_t check = 0;       // of the content
};

constexpr std::size_t kHeadSize = 24;

/// The largest content of a chunk of each kind. A longer one is forged, not torn. The writer ends a
/// chunk with the record that fills kChunkSize; the longest record is a tick that jumped.
constexpr std::size_t kMostRecords = kChunkSize + 9 + 9 + 4 * (kStatusMembers + kMostRows);
constexpr std::size_t kMostState = 256U << 20U;  // 16 KiB for each of 16,384 axes
constexpr std::size_t kEndSize = 24;

constexpr std::size_t kReadAtOnce = 1U << 20U;

std::uint32_t head_check_of(const ChunkHead& head) {
  const std::array<std::uint32_t, 3> words{head.kind, head.length, head.sequence};
  const std::uint64_t check = check_of(std::as_bytes(std::span(words)));
  return static_cast<std::uint32_t>(check ^ (check >> 32U));
}

bool has_value(JournalChange::Kind kind) {
  return kind == JournalChange::Kind::write || kind == JournalChange::Kind::stored;
}

/// Writes a number as it is in memory: little-endian on all machines that vdrive supports.
/// AxisBank::snapshot_layout identifies the kind of machine.
template <typename Number>
void put(std::vector<std::byte>& bytes, Number number) {
  static_assert(std::is_integral_v<Number>);
  const auto source = std::as_bytes(std::span(&number, 1));
  bytes.insert(bytes.end(), source.begin(), source.end());
}

void put_text(std::vector<std::byte>& bytes, const std::string& text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  const auto source = std::as_bytes(std::span(text));
  bytes.insert(bytes.end(), source.begin(), source.end());
}

void put_chunk(std::uint32_t kind, std::uint32_t sequence, std::span<const std::byte> content,
               std::vector<std::byte>& chunk) {
  ChunkHead head{.kind = kind,
                 .length = static_cast<std::uint32_t>(content.size()),
                 .sequence = sequence,
                 .check = check_of(content)};
  head.head_check = head_check_of(head);
  chunk.clear();
  put(chunk, head.kind);
  put(chunk, head.length);
  put(chunk, head.sequence);
  put(chunk, head.head_check);
  put(chunk, head.check);
  chunk.insert(chunk.end(), content.begin(), content.end());
}

}  // namespace

JournalWriter::JournalWriter(JournalSink sink, const JournalStart& start) : sink_(std::move(sink)) {
  records_.reserve(2 * kChunkSize);
  std::vector<std::byte> content;
  put(content, kJournalMagic);
  put(content, kVersion);
  put(content, start.axes_per_row);
  put(content, start.rows);
  put(content, start.layout);
  put_text(content, start.version);
  put_text(content, start.configuration);
  put_chunk(kStart, sequence_++, content, chunk_);
  sink_(chunk_);
}

void JournalWriter::write(const JournalChange& change) {
  put(records_, static_cast<std::uint8_t>(change.kind));
  put(records_, change.axis);
  if (has_value(change.kind)) {
    put(records_, change.address.index);
    put(records_, change.address.subindex);
    put(records_, change.value);
  }
  ++totals_.changes;
  flush_if_large();
}

void JournalWriter::write(const JournalRefusal& refusal) {
  put(records_, kRefusal);
  put(records_, refusal.axis);
  put(records_, refusal.address.index);
  put(records_, refusal.address.subindex);
  put(records_, refusal.value);
  put(records_, refusal.reason);
  flush_if_large();
}

void JournalWriter::write(const JournalAuthor& author) {
  put(records_, kAuthor);
  put(records_, static_cast<std::uint8_t>(author.means));
  put(records_, author.session);
  flush_if_large();
}

void JournalWriter::write(const JournalSnapshot& snapshot) {
  flush();
  std::vector<std::byte> content;
  content.reserve(snapshot.state.size() + kHeadSize);
  put(content, static_cast<std::uint8_t>(snapshot.cause));
  put(content, snapshot.tick);
  put(content, snapshot.lost);
  content.insert(content.end(), snapshot.state.begin(), snapshot.state.end());
  put_chunk(kSnapshot, sequence_++, content, chunk_);
  sink_(chunk_);
  totals_.lost += snapshot.lost;
  last_tick_ = snapshot.tick;
  last_image_.reset();
}

void JournalWriter::write_tick(std::uint64_t number, const StatusDigest& digest,
                               std::span<const std::uint32_t> rows) {
  if (number != last_tick_ + 1) {
    put(records_, kJump);
    put(records_, number);
  }
  if (last_image_ == digest.image) {
    put(records_, kSameTick);
  } else {
    put(records_, kTick);
    put(records_, digest.image);
    for (const std::uint32_t check : digest.members) put(records_, check);
    for (const std::uint32_t check : rows) put(records_, check);
  }
  last_tick_ = number;
  last_image_ = digest.image;
  ++totals_.ticks;
  flush_if_large();
}

void JournalWriter::flush() {
  if (!records_.empty()) {
    put_chunk(kRecords, sequence_++, records_, chunk_);
    records_.clear();
    sink_(chunk_);
  }
}

void JournalWriter::flush_if_large() {
  if (records_.size() >= kChunkSize) flush();
}

void JournalWriter::end() {
  flush();
  std::vector<std::byte> content;
  put(content, totals_.ticks);
  put(content, totals_.changes);
  put(content, totals_.lost);
  put_chunk(kEnd, sequence_++, content, chunk_);
  sink_(chunk_);
}

JournalReader::JournalReader(std::istream& file) : file_(file) {
  if (!read_chunk() || kind_ != kStart) fail("this is not a journal");
  read_start();
}

void JournalReader::read_start() {
  if (take<std::uint64_t>() != kJournalMagic) fail("this is not a journal");
  format_ = take<std::uint32_t>();
  if (format_ < kFirstVersion || format_ > kVersion) {
    fail("version " + std::to_string(format_) + " of the format is not supported; supported: " +
         std::to_string(kFirstVersion) + " to " + std::to_string(kVersion));
  }
  start_.axes_per_row = take<std::uint32_t>();
  start_.rows = take<std::uint32_t>();
  start_.layout = take<std::uint64_t>();
  start_.version = take_text();
  start_.configuration = take_text();
  if (start_.axes_per_row == 0 || start_.rows > kMostRows) fail("the header is not valid");
}

std::optional<JournalRecord> JournalReader::next() {
  while (position_ == chunk_.size()) {
    if (!read_chunk()) return std::nullopt;
  }
  switch (kind_) {
    case kRecords:
      return read_record();
    case kSnapshot:
      return read_snapshot();
    case kEnd:
      return JournalEnd{.ticks = take<std::uint64_t>(),
                        .changes = take<std::uint64_t>(),
                        .lost = take<std::uint64_t>()};
    default:
      fail("a second start chunk was found");
  }
}

/// Allocates only as the bytes arrive, because the length may be forged.
bool JournalReader::read_bytes(std::size_t length) {
  chunk_.clear();
  position_ = 0;
  while (chunk_.size() < length) {
    const std::size_t begin = chunk_.size();
    chunk_.resize(begin + std::min(kReadAtOnce, length - begin));
    file_.read(reinterpret_cast<char*>(&chunk_[begin]),  // NOLINT(*-reinterpret-cast): raw bytes
               static_cast<std::streamsize>(chunk_.size() - begin));
    if (const auto count = static_cast<std::size_t>(file_.gcount());
        count < chunk_.size() - begin) {
      chunk_.resize(begin + count);
      return false;
    }
  }
  return true;
}

void JournalReader::require_length(std::uint32_t kind, std::uint32_t length) const {
  std::size_t most = 0;
  switch (kind) {
    case kStart:
    case kSnapshot:
      most = kMostState;
      break;
    case kRecords:
      most = kMostRecords;
      break;
    case kEnd:
      most = kEndSize;
      break;
    default:
      fail("unknown kind of chunk: " + std::to_string(kind));
  }
  if (length > most) {
    fail("a chunk of kind " + std::to_string(kind) + " with " + std::to_string(length) +
         " bytes; the limit is " + std::to_string(most));
  }
}

/// Counts the ticks in the unfinished chunk at the end of the file. Its check cannot be verified,
/// and more ticks may have been recorded than it contains.
void JournalReader::count_torn_ticks() {
  try {
    while (kind_ == kRecords && position_ < chunk_.size()) {
      torn_ticks_ += std::holds_alternative<JournalTick>(read_record()) ? 1 : 0;
    }
  } catch (const JournalError&) {  // NOLINT(bugprone-empty-catch): the record that is cut off
  }
  chunk_.clear();
  position_ = 0;
}

bool JournalReader::read_chunk() {
  chunk_offset_ = next_offset_;
  if (!read_bytes(kHeadSize)) {
    torn_bytes_ = chunk_.size();
    chunk_.clear();
    return false;
  }
  ChunkHead head{.kind = take<std::uint32_t>(),
                 .length = take<std::uint32_t>(),
                 .sequence = take<std::uint32_t>(),
                 .head_check = take<std::uint32_t>(),
                 .check = take<std::uint64_t>()};
  if (head.head_check != head_check_of(head)) {
    fail(chunk_offset_ == 0 ? "this is not a journal" : "the header of a chunk is damaged");
  }
  if (head.sequence != sequence_) {
    fail("chunk " + std::to_string(head.sequence) + " was found, expected chunk " +
         std::to_string(sequence_));
  }
  require_length(head.kind, head.length);
  kind_ = head.kind;
  if (!read_bytes(head.length)) {
    torn_bytes_ = kHeadSize + chunk_.size();
    count_torn_ticks();
    return false;
  }
  if (head.check != check_of(chunk_)) fail("the content of a chunk is damaged");
  ++sequence_;
  next_offset_ += kHeadSize + chunk_.size();
  return true;
}

JournalRecord JournalReader::read_record() {
  auto kind = take<std::uint8_t>();
  if (kind == kJump) {
    tick_.number = take<std::uint64_t>() - 1;
    kind = take<std::uint8_t>();
  }
  switch (kind) {
    case kSameTick:
      ++tick_.number;
      return tick_;
    case kTick:
      ++tick_.number;
      tick_.digest.image = take<std::uint64_t>();
      for (std::uint32_t& check : tick_.digest.members) check = take<std::uint32_t>();
      tick_.rows.resize(start_.rows);
      for (std::uint32_t& check : tick_.rows) check = take<std::uint32_t>();
      return tick_;
    case kAuthor: {
      const auto means = take<std::uint8_t>();
      if (means > static_cast<std::uint8_t>(JournalAuthor::Means::frame)) {
        fail("unknown kind of author: " + std::to_string(means));
      }
      return JournalAuthor{.means = static_cast<JournalAuthor::Means>(means),
                           .session = take<std::uint64_t>()};
    }
    case kRefusal: {
      JournalRefusal refusal{.axis = take<std::uint16_t>()};
      refusal.address = take_address();
      refusal.value = take<std::int64_t>();
      refusal.reason = take<std::uint32_t>();
      return refusal;
    }
    default:
      return read_change(static_cast<JournalChange::Kind>(kind));
  }
}

JournalRecord JournalReader::read_change(JournalChange::Kind kind) {
  JournalChange change{.kind = kind, .axis = take<std::uint16_t>()};
  switch (kind) {
    case JournalChange::Kind::write:
    case JournalChange::Kind::stored:
      change.address = take_address();
      change.value = take<std::int64_t>();
      return change;
    case JournalChange::Kind::power_cycle:
    case JournalChange::Kind::connection_loss:
    case JournalChange::Kind::forgot:
      return change;
  }
  fail("unknown kind of record: " + std::to_string(static_cast<unsigned>(kind)));
}

JournalRecord JournalReader::read_snapshot() {
  JournalSnapshot snapshot;
  const auto cause = take<std::uint8_t>();
  if (cause < 1 || cause > 3) fail("unknown cause of a snapshot: " + std::to_string(cause));
  snapshot.cause = static_cast<JournalSnapshot::Cause>(cause);
  snapshot.tick = take<std::uint64_t>();
  snapshot.lost = take<std::uint64_t>();
  snapshot.state.assign(chunk_.begin() + static_cast<std::ptrdiff_t>(position_), chunk_.end());
  position_ = chunk_.size();
  tick_ = {.number = snapshot.tick};
  return snapshot;
}

template <typename Number>
Number JournalReader::take() {
  Number number{};
  if (chunk_.size() - position_ < sizeof(number)) fail("a record is incomplete");
  std::memcpy(&number, chunk_.data() + position_, sizeof(number));
  position_ += sizeof(number);
  return number;
}

ObjectAddress JournalReader::take_address() {
  ObjectAddress address;
  address.index = take<std::uint16_t>();
  address.subindex = take<std::uint8_t>();
  return address;
}

std::string JournalReader::take_text() {
  const auto length = take<std::uint32_t>();
  if (chunk_.size() - position_ < length) {
    fail("a text of " + std::to_string(length) + " bytes is incomplete");
  }
  std::string text(length, '\0');
  std::memcpy(text.data(), chunk_.data() + position_, text.size());
  position_ += text.size();
  return text;
}

void JournalReader::fail(const std::string& what) const {
  throw JournalError("byte " + std::to_string(chunk_offset_) + ": " + what);
}

}  // namespace vdrive::service
