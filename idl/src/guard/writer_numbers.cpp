// SPDX-License-Identifier: Apache-2.0
#include "writer_numbers.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace vdrive::wire {

/// The sequence numbers in a submessage.
struct WriterNumbers::Numbers {
  SubmessageKind kind{};
  EntityId writer = kUnknownEntity;
  std::int64_t first = 0;
  std::int64_t last = 0;                  ///< first - 1 if there is none
  std::int64_t skipped = 0;               ///< how many a GAP tells the library to skip
  std::span<const std::size_t> places{};  ///< offsets of the numbers in the body

  [[nodiscard]] bool is_heartbeat() const noexcept { return kind == SubmessageKind::heartbeat; }

  [[nodiscard]] bool is_data() const noexcept {
    return kind == SubmessageKind::data || kind == SubmessageKind::data_frag;
  }
};

namespace {

/// Adds `difference` to the sequence numbers at these offsets of a submessage, in a copy of the
/// datagram that is made at the first change.
void add_to_numbers(std::vector<std::uint8_t>& copy, ByteView datagram,
                    const Submessage& submessage, std::span<const std::size_t> offsets,
                    std::int64_t difference) {
  constexpr std::size_t kNumberSize = 8;
  const bool little = submessage.has(kLittle);
  if (copy.empty()) copy.assign(datagram.begin(), datagram.end());
  for (const std::size_t offset : offsets) {
    const auto place = std::span(copy).subspan(submessage.offset + offset, kNumberSize);
    ByteReader reader(place, little);
    const auto number = static_cast<std::uint64_t>(reader.sequence() + difference);
    put_u32(place, static_cast<std::uint32_t>(number >> 32U), little);
    put_u32(place.subspan(4), static_cast<std::uint32_t>(number), little);
  }
}

/// INFO_SRC names the participant that the rest of a datagram is from, INFO_DST the one that it is
/// for.
void read_prefix(const Submessage& submessage, SubmessageKind kind, std::size_t offset,
                 GuidPrefix& participant) {
  if (submessage.kind != kind) return;
  ByteReader reader = submessage.reader();
  reader.skip(offset);
  const ByteView prefix = reader.bytes(participant.size());
  if (reader.ok()) std::ranges::copy(prefix, participant.begin());
}

}  // namespace

void WriterNumbers::found(const GuidPrefix& participant) {
  const std::scoped_lock lock(mutex_);
  participants_.try_emplace(participant);
}

void WriterNumbers::removed(const GuidPrefix& participant) {
  const std::scoped_lock lock(mutex_);
  participants_.erase(participant);
}

std::optional<WriterNumbers::Numbers> WriterNumbers::numbers_in(const Submessage& submessage) {
  static constexpr std::array<std::size_t, 1> kOfData{12};
  static constexpr std::array<std::size_t, 2> kOfRange{8, 16};
  Numbers numbers{.kind = submessage.kind};
  ByteReader reader = submessage.reader();
  if (numbers.is_data()) {
    reader.skip(8);
    numbers.writer = reader.entity();
    numbers.first = reader.sequence();
    numbers.last = numbers.first;
    numbers.places = kOfData;
    // Announcements are not processed number by number, and one made by the guard has the highest
    // number.
    return numbers.writer == kParticipantsWriter ? std::nullopt : std::optional(numbers);
  }
  if (!numbers.is_heartbeat() && submessage.kind != SubmessageKind::gap) return std::nullopt;
  reader.skip(4);
  numbers.writer = reader.entity();
  numbers.first = reader.sequence();
  numbers.last = reader.sequence();
  numbers.places = kOfRange;
  if (!numbers.is_heartbeat()) {
    numbers.skipped = numbers.last - numbers.first;
    numbers.last += static_cast<std::int64_t>(reader.u32()) - 1;  // the base of a set of bits
  }
  return numbers;
}

/// @param rest of the datagram: a GAP precedes the heartbeat that it belongs to
/// @return nothing for numbers with which no writer starts.
std::optional<WriterNumbers::Writer> WriterNumbers::begin(const Numbers& numbers,
                                                          Submessages rest) {
  // Writers of discovery have sent as many samples as there are endpoints.
  if (is_built_in(numbers.writer)) {
    if (numbers.last > kMostOfDiscovery) return std::nullopt;
    return Writer{.highest = numbers.last, .done = numbers.first - 1, .is_reliable = true};
  }
  std::optional<Numbers> heartbeat;
  if (numbers.is_heartbeat()) heartbeat = numbers;
  for (Submessage submessage; !heartbeat && !rest.at_end() && rest.next(submessage);) {
    const auto later = numbers_in(submessage);
    if (later && later->is_heartbeat() && later->writer == numbers.writer) heartbeat = later;
  }
  // A writer without heartbeats keeps its numbers: the library does not process them one by one.
  if (!heartbeat) return Writer{.highest = numbers.last};
  const std::int64_t before = heartbeat->first - 1;
  return Writer{.base = before >= kNear ? before : 0,
                .highest = heartbeat->last,
                .done = before,
                .is_reliable = true};
}

WriterNumbers::Writer* WriterNumbers::writer_of(Writers& writers, const Numbers& numbers,
                                                Submessages rest) {
  const auto known = writers.find(numbers.writer);
  if (known != writers.end()) return &known->second;
  const auto writer = begin(numbers, rest);
  if (!writer || writers.size() >= kMostWriters) return nullptr;
  return &writers.emplace(numbers.writer, *writer).first->second;
}

bool WriterNumbers::is_plausible(const Numbers& numbers, const Writer& writer) {
  if (numbers.first <= writer.base) return false;
  if (numbers.is_data()) {
    return numbers.last <= writer.highest + (writer.is_reliable ? kReach : kReachOfBestEffort);
  }
  // A heartbeat skips all numbers before its first number; a gap skips all from its first number up
  // to its base.
  return numbers.last <= writer.highest + kReach &&
         (!numbers.is_heartbeat() || numbers.first <= writer.done + 1 + kReach);
}

bool WriterNumbers::has_jumped(const Numbers& numbers, Writer& writer, Clock::time_point now) {
  // This is the first heartbeat or gap of a writer of which only data was heard: an earlier
  // heartbeat may be lost, in which case the library has read large numbers unchanged and must
  // start over at once. Numbers that do not fit the data are doubted as usual.
  const bool fits_data =
      numbers.last <= writer.highest + kReach && numbers.last + kReach >= writer.highest;
  if (!writer.is_reliable && !numbers.is_data() && fits_data) return true;
  const auto since = now - writer.doubted;
  if (since > kMemory) writer.doubted = now;
  return since >= kDoubt && since <= kMemory;
}

/// Records plausible numbers of a writer.
/// @return false if they would make the library skip too many numbers in this second.
bool WriterNumbers::take(const Numbers& numbers, Writer& writer, Clock::time_point now) {
  // For a writer that sends heartbeats, plausible data does not end a doubt: if its heartbeats are
  // refused, nothing is acknowledged.
  if (!writer.is_reliable || !numbers.is_data()) writer.doubted = {};
  writer.is_reliable = writer.is_reliable || !numbers.is_data();
  writer.highest = std::max(writer.highest, numbers.last);
  const std::int64_t done = numbers.is_heartbeat() ? std::max(writer.done, numbers.first - 1)
                                                   : writer.done + numbers.skipped;
  if (done != writer.done && !may_skip(done - writer.done, now)) return false;
  // A gap may skip numbers that the library has not reached yet: only an acknowledgement shows that
  // it has.
  if (numbers.is_heartbeat()) writer.done = done;
  return true;
}

bool WriterNumbers::may_skip(std::int64_t count, Clock::time_point now) {
  const std::int64_t second =
      std::chrono::duration_cast<std::chrono::seconds>(now.time_since_epoch()).count();
  if (second != second_) {
    second_ = second;
    skipped_ = 0;
  }
  if (skipped_ > kSkippedInASecond) return false;
  skipped_ += count;
  return true;
}

WriterNumbers::Judgement WriterNumbers::judge(const GuidPrefix& source, const Numbers& numbers,
                                              Submessages rest, Clock::time_point now) {
  const auto participant = participants_.find(source);
  if (participant == participants_.end()) return {};
  Writer* const writer = writer_of(participant->second, numbers, rest);
  if (writer == nullptr) return {.refusal = Refusal::jump};
  if (!is_plausible(numbers, *writer)) {
    return {.refusal = Refusal::jump, .is_astray = has_jumped(numbers, *writer, now)};
  }
  return {.refusal = take(numbers, *writer, now) ? Refusal::none : Refusal::range,
          .base = writer->base};
}

WriterNumbers::Report WriterNumbers::receive(ByteView datagram, Clock::time_point now,
                                             std::vector<std::uint8_t>& renumbered) {
  constexpr std::size_t kOfSource = 8;  // after four unused bytes, version and vendor
  Report report;
  GuidPrefix source = sender_of(datagram);
  Submessages submessages(datagram);
  const std::scoped_lock lock(mutex_);
  for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
    read_prefix(submessage, SubmessageKind::info_src, kOfSource, source);
    const auto numbers = numbers_in(submessage);
    if (!numbers) continue;
    const Judgement judgement = judge(source, *numbers, submessages, now);
    if (judgement.is_astray) report.needs_resync = source;
    report.refusal = judgement.refusal;
    if (report.refusal != Refusal::none) return report;
    if (judgement.base == 0) continue;
    report.is_renumbered = true;
    add_to_numbers(renumbered, datagram, submessage, numbers->places, -judgement.base);
  }
  return report;
}

/// ACKNACK or NACK_FRAG.
struct WriterNumbers::Answer {
  EntityId writer = kUnknownEntity;
  std::int64_t number = 0;
  bool acknowledges = false;  ///< all before the number
};

std::optional<WriterNumbers::Answer> WriterNumbers::answer_in(const Submessage& submessage) {
  const bool acknowledges = submessage.kind == SubmessageKind::acknack;
  if (!acknowledges && submessage.kind != SubmessageKind::nack_frag) return std::nullopt;
  ByteReader reader = submessage.reader();
  reader.skip(4);  // the reader
  Answer answer{.acknowledges = acknowledges};
  answer.writer = reader.entity();
  answer.number = reader.sequence();
  // 0 requests a first heartbeat.
  return reader.ok() && answer.number != 0 ? std::optional(answer) : std::nullopt;
}

/// @return the number to add to that of the answer.
std::int64_t WriterNumbers::pass(const GuidPrefix& receiver, const Answer& answer) {
  const std::scoped_lock lock(mutex_);
  const auto participant = participants_.find(receiver);
  if (participant == participants_.end()) return 0;
  const auto found = participant->second.find(answer.writer);
  if (found == participant->second.end()) return 0;
  Writer& writer = found->second;
  if (answer.acknowledges) {
    writer.done = std::max(writer.done, answer.number + writer.base - 1);
  }
  return writer.base;
}

bool WriterNumbers::send(ByteView datagram, std::vector<std::uint8_t>& renumbered) {
  static constexpr std::array<std::size_t, 1> kPlace{8};
  GuidPrefix receiver{};
  Submessages submessages(datagram);
  for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
    read_prefix(submessage, SubmessageKind::info_dst, 0, receiver);
    const auto answer = answer_in(submessage);
    const std::int64_t base = answer ? pass(receiver, *answer) : 0;
    if (base != 0) add_to_numbers(renumbered, datagram, submessage, kPlace, base);
  }
  return !renumbered.empty();
}

}  // namespace vdrive::wire
