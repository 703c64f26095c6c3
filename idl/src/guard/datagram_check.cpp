// SPDX-License-Identifier: Apache-2.0
#include "datagram_check.hpp"

#include "rtps.hpp"
#include "security_check.hpp"

#include <algorithm>

namespace vdrive::wire {
namespace {

/// A CDR string: its length including the final NUL, then that many bytes, padded to four.
bool skip_text(ByteReader& reader) {
  const std::uint32_t length = reader.u32();
  if (!reader.ok() || length > reader.left()) return false;
  reader.skip(length);
  // The last string need not be padded.
  reader.skip(std::min<std::size_t>(reader.left(), (4 - length % 4) % 4));
  return true;
}

bool skip_texts(ByteReader& reader, std::uint32_t count) {
  for (; count != 0; --count) {
    if (!skip_text(reader)) return false;
  }
  return reader.ok();
}

bool is_text(ByteView value, bool little) {
  ByteReader reader(value, little);
  return skip_text(reader);
}

/// The library adds each length to a 32-bit position, as many times as the count says.
bool is_partition(ByteView value, bool little) {
  ByteReader reader(value, little);
  return skip_texts(reader, reader.u32());
}

/// The library appends as many numbers as the count says; those past the end are 0.
bool is_data_representation(ByteView value, bool little) {
  ByteReader reader(value, little);
  const std::uint32_t count = reader.u32();
  return reader.ok() && count <= reader.left() / 2;
}

/// Like is_data_representation(), but other vendors use this parameter for something else: refuses
/// only a count for which no parameter has room.
bool may_be_data_sharing(ByteView value, bool little) {
  constexpr std::uint32_t kMostDomains = 0xFFFF / 8;
  ByteReader reader(value, little);
  return reader.u32() <= kMostDomains;
}

/// Names of two topics and of a class, the expression and its parameters. The library allocates the
/// length of the expression before it checks it.
bool is_content_filter(ByteView value, bool little) {
  constexpr std::size_t kSmallest = 36;  // [bytes] the library does not read a smaller one
  ByteReader reader(value, little);
  return value.size() < kSmallest || (skip_texts(reader, 4) && skip_texts(reader, reader.u32()));
}

/// Checks parameters whose length the library does not check: they must have at least the length
/// that it reads.
bool is_parameter(const ListEntry& entry, bool little) {
  switch (entry.id) {
    case kEntityName:
    case kTopicName:
    case kTypeName:
      return is_text(entry.value, little);
    case kPartition:
      return is_partition(entry.value, little);
    case kDataRepresentation:
      return is_data_representation(entry.value, little);
    case kDataSharing:
      return may_be_data_sharing(entry.value, little);
    case kContentFilter:
      return is_content_filter(entry.value, little);
    case kParticipantGuid:
      return entry.value.size() >= 16;
    case kLease:
      return entry.value.size() >= 8;
    case kIdentityToken:
    case kPermissionsToken:
      return is_token(entry.value, little);
    default:
      return true;
  }
}

}  // namespace

Refusal check_list(ByteView bytes, bool little) noexcept {
  ParameterList list(bytes, little);
  for (ListEntry entry; list.next(entry);) {
    if (!is_parameter(entry, little)) return Refusal::parameters;
  }
  return list.ended() ? Refusal::none : Refusal::parameters;
}

DataSubmessage parse_data(const Submessage& submessage, std::size_t fixed) noexcept {
  DataSubmessage data;
  ByteReader reader = submessage.reader();
  reader.skip(2);
  const std::size_t to_inline_qos = reader.u16();
  data.reader = reader.entity();
  data.writer = reader.entity();
  data.sequence = reader.sequence();
  // A smaller offset would point into the fixed part; the library uses it without a check.
  if (!reader.ok() || to_inline_qos < fixed || to_inline_qos % 4 != 0 ||
      to_inline_qos + 4 > submessage.body.size()) {
    return data;
  }
  data.payload = to_inline_qos + 4;
  if (submessage.has(kSecond)) {
    ParameterList list(submessage.body.subspan(data.payload), submessage.has(kLittle));
    for (ListEntry entry; list.next(entry);) {
    }
    if (!list.ended()) return data;
    data.inline_qos = submessage.body.subspan(data.payload, list.size());
    data.payload += list.size();
  }
  data.content = submessage.body.subspan(data.payload);
  data.whole = true;
  return data;
}

bool may_announce(const Submessage& submessage, const DataSubmessage& data) noexcept {
  if (data.reader == kParticipantsReader || data.writer == kParticipantsWriter) return true;
  // Data for any reader also reaches the reader of announcements, which accepts whatever looks like
  // an announcement.
  if (data.reader != kUnknownEntity || !submessage.has(kThird) || !data.is_list()) return false;
  ParameterList list(data.list(), data.list_is_little());
  for (ListEntry entry; list.next(entry);) {
    if (entry.id == kParticipantGuid) return true;
  }
  return false;
}

bool is_discovery(const Submessage& submessage, const DataSubmessage& data) noexcept {
  constexpr std::array<std::uint32_t, 6> kOfDiscovery{kPublicationsWriter,  kPublicationsReader,
                                                      kSubscriptionsWriter, kSubscriptionsReader,
                                                      kParticipantsWriter,  kParticipantsReader};
  const bool is_for_it = std::ranges::any_of(kOfDiscovery, [&data](std::uint32_t entity) {
    return data.reader == entity || data.writer == entity;
  });
  return is_for_it || may_announce(submessage, data);
}

std::span<std::uint8_t> list_in(std::span<std::uint8_t> datagram, const Submessage& submessage,
                                const DataSubmessage& data) noexcept {
  return datagram.subspan(submessage.offset + data.payload + kEncapsulationSize,
                          data.list().size());
}

namespace {

constexpr std::uint8_t kMajorVersion = 2;
constexpr std::int64_t kLargestSequence = std::int64_t{1} << 40U;  // 34 years at one per ms
constexpr std::uint32_t kMostBits = 256;  // of a set of numbers (RTPS 2.5, 9.4.2.6)
constexpr std::uint32_t kLargestSample = 16U * 1024U * 1024U;  // [bytes]
// The library stores a four-byte number at the start of each missing fragment.
constexpr std::uint32_t kSmallestFragment = 16;  // [bytes]
constexpr std::size_t kFragmentFixed = 28;       // [bytes] of a DATA_FRAG before its lists

bool is_sequence(std::int64_t number, std::int64_t least) {
  return number >= least && number <= kLargestSequence;
}

/// The base has been read; the number of bits and the words follow.
Refusal check_set(ByteReader& reader) {
  const std::uint32_t bits = reader.u32();
  if (bits > kMostBits) return Refusal::set;
  reader.skip(std::size_t{(bits + 31) / 32} * 4);
  return reader.ok() ? Refusal::none : Refusal::length;
}

Refusal check_acknack(const Submessage& submessage) {
  ByteReader reader = submessage.reader();
  reader.skip(8);
  // 0 requests a first heartbeat.
  if (!is_sequence(reader.sequence(), 0)) return Refusal::sequence;
  const Refusal refusal = check_set(reader);
  reader.skip(4);
  return refusal == Refusal::none && !reader.ok() ? Refusal::length : refusal;
}

Refusal check_heartbeat(const Submessage& submessage) {
  ByteReader reader = submessage.reader();
  reader.skip(8);
  const std::int64_t first = reader.sequence();
  const std::int64_t last = reader.sequence();
  reader.skip(4);
  if (!reader.ok()) return Refusal::length;
  if (!is_sequence(first, 1) || !is_sequence(last, 0)) return Refusal::sequence;
  return last >= first - 1 ? Refusal::none : Refusal::range;
}

Refusal check_gap(const Submessage& submessage) {
  ByteReader reader = submessage.reader();
  reader.skip(8);
  const std::int64_t start = reader.sequence();
  const std::int64_t base = reader.sequence();
  const Refusal set = check_set(reader);
  if (set != Refusal::none) return set;
  if (!is_sequence(start, 1) || !is_sequence(base, 1)) return Refusal::sequence;
  if (base < start || base - start > kWidestGap) return Refusal::range;
  return Refusal::none;
}

Refusal check_nack_frag(const Submessage& submessage) {
  ByteReader reader = submessage.reader();
  reader.skip(8);
  const std::int64_t sequence = reader.sequence();
  const std::uint32_t base = reader.u32();
  const Refusal set = check_set(reader);
  reader.skip(4);
  if (set != Refusal::none || !reader.ok()) return set != Refusal::none ? set : Refusal::length;
  if (!is_sequence(sequence, 1)) return Refusal::sequence;
  return base >= 1 && base <= kLargestSample ? Refusal::none : Refusal::fragment;
}

Refusal check_heartbeat_frag(const Submessage& submessage) {
  ByteReader reader = submessage.reader();
  reader.skip(8);
  const std::int64_t sequence = reader.sequence();
  reader.skip(8);
  if (!reader.ok()) return Refusal::length;
  return is_sequence(sequence, 1) ? Refusal::none : Refusal::sequence;
}

/// @return whether the inline QoS marks an instance as disposed or unregistered.
bool says_gone(const Submessage& submessage, const DataSubmessage& data) {
  ParameterList list(data.inline_qos, submessage.has(kLittle));
  for (ListEntry entry; list.next(entry);) {
    if (entry.id == kStatusInfo && entry.value.size() >= 4) return (entry.value[3] & 3U) != 0;
  }
  return false;
}

Refusal check_discovery(const Submessage& submessage, const DataSubmessage& data) {
  if (submessage.has(kThird)) {
    return data.is_list() ? check_list(data.list(), data.list_is_little()) : Refusal::parameters;
  }
  return says_gone(submessage, data) ? Refusal::none : Refusal::data;
}

bool is_of_handshake(const DataSubmessage& data) {
  return data.reader == kHandshakeReader || data.writer == kHandshakeWriter;
}

Refusal check_data(const Submessage& submessage, DatagramReport& report) {
  const DataSubmessage data = parse_data(submessage, kDataFixed);
  if (!data.whole) return Refusal::length;
  if (!is_sequence(data.sequence, 1)) return Refusal::sequence;
  const bool has_data = submessage.has(kThird);
  const bool has_key = submessage.has(kFourth);
  if ((has_data && has_key) || ((has_data || has_key) && data.content.size() < 4) ||
      (!has_data && !has_key && data.inline_qos.empty()) || data.writer == kUnknownEntity) {
    return Refusal::data;
  }
  if (is_of_handshake(data)) {
    return is_handshake(submessage, data) ? Refusal::none : Refusal::handshake;
  }
  if (is_discovery(submessage, data)) {
    report.announces = true;
    return check_discovery(submessage, data);
  }
  return Refusal::none;
}

Refusal check_data_frag(const Submessage& submessage) {
  const DataSubmessage data = parse_data(submessage, kFragmentFixed);
  if (!data.whole) return Refusal::length;
  if (!is_sequence(data.sequence, 1)) return Refusal::sequence;
  ByteReader reader = submessage.reader();
  reader.skip(20);
  const std::uint64_t first = reader.u32();
  const std::uint64_t count = reader.u16();
  const std::uint64_t size = reader.u16();
  const std::uint64_t sample = reader.u32();
  if (first == 0 || count == 0 || size < kSmallestFragment || sample == 0 ||
      sample > kLargestSample || data.writer == kUnknownEntity) {
    return Refusal::fragment;
  }
  const std::uint64_t fragments = (sample + size - 1) / size;
  // The library writes the number of a missing fragment (kSmallestFragment) at the next multiple of
  // four, even if a short last fragment ends before that. The memory of a sample ends at a multiple
  // of four, so positions inside the sample are safe.
  if ((((fragments - 1) * size + 3) & ~std::uint64_t{3}) >= sample) return Refusal::fragment;
  const std::uint64_t behind = first - 1 + count;
  if (behind > fragments ||
      data.content.size() < std::min(behind * size, sample) - (first - 1) * size) {
    return Refusal::fragment;
  }
  // Fragmented content cannot be checked; announcements and handshakes fit into one datagram.
  if (is_of_handshake(data)) return Refusal::handshake;
  const bool announces = data.reader == kParticipantsReader || data.writer == kParticipantsWriter;
  return announces ? Refusal::announcement : Refusal::none;
}

Refusal need(const Submessage& submessage, std::size_t size) {
  return submessage.body.size() >= size ? Refusal::none : Refusal::length;
}

Refusal check_submessage(const Submessage& submessage, DatagramReport& report) {
  switch (submessage.kind) {
    case SubmessageKind::pad:
    case SubmessageKind::sec_body:  // SecureOrder has checked the encrypted parts
    case SubmessageKind::sec_prefix:
    case SubmessageKind::sec_postfix:
    case SubmessageKind::srtps_prefix:
    case SubmessageKind::srtps_postfix:
      return Refusal::none;
    case SubmessageKind::acknack:
      return check_acknack(submessage);
    case SubmessageKind::heartbeat:
      return check_heartbeat(submessage);
    case SubmessageKind::gap:
      return check_gap(submessage);
    case SubmessageKind::nack_frag:
      return check_nack_frag(submessage);
    case SubmessageKind::heartbeat_frag:
      return check_heartbeat_frag(submessage);
    case SubmessageKind::data:
      return check_data(submessage, report);
    case SubmessageKind::data_frag:
      return check_data_frag(submessage);
    case SubmessageKind::info_ts:
      return need(submessage, submessage.has(kSecond) ? 0 : 8);
    case SubmessageKind::info_src:
      return need(submessage, 20);
    case SubmessageKind::info_reply_ip4:
      return need(submessage, 8);
    case SubmessageKind::info_dst:
      return need(submessage, 12);
    case SubmessageKind::info_reply:
      return need(submessage, 4);
    default:
      // From 0x80 on each vendor has its own kinds, which others skip.
      return submessage.kind >= SubmessageKind::statistics ? Refusal::none : Refusal::submessage;
  }
}

Refusal check_in_place(const Submessage& submessage, SecureOrder& order, Mode mode,
                       DatagramReport& report) {
  const Refusal refusal = order.next(submessage);
  if (refusal != Refusal::none) return refusal;
  if (mode == Mode::closed && !may_be_in_clear(submessage)) return Refusal::unprotected;
  return check_submessage(submessage, report);
}

bool is_header(ByteView datagram) {
  constexpr std::array<std::uint8_t, 5> kStart{'R', 'T', 'P', 'S', kMajorVersion};
  return datagram.size() >= kHeaderSize &&
         std::equal(kStart.begin(), kStart.end(), datagram.begin());
}

/// Fast DDS reads submessage 0x80 of its own vendor before anything else, without a check.
bool is_from_fast_dds(ByteView datagram) {
  return datagram[6] == 1 && datagram[7] == 15;
}

}  // namespace

DatagramReport check_datagram(std::span<const std::uint8_t> datagram, Mode mode) noexcept {
  DatagramReport report{.length = datagram.size()};
  if (!is_header(datagram)) {
    report.refusal = Refusal::header;
    return report;
  }
  Submessages submessages(datagram);
  Submessage submessage;
  SecureOrder order;
  while (!submessages.at_end()) {
    if (!submessages.next(submessage)) {
      report.refusal = Refusal::length;
      return report;
    }
    if (submessage.kind == SubmessageKind::statistics && is_from_fast_dds(datagram)) {
      const bool is_whole = submessage.last && submessage.body.size() == kStatisticsSize;
      report.refusal = is_whole ? Refusal::none : Refusal::statistics;
      report.length = submessage.offset - kSubmessageHeaderSize;
      break;
    }
    report.refusal = check_in_place(submessage, order, mode, report);
    if (report.refusal != Refusal::none) return report;
  }
  if (report.refusal == Refusal::none && !order.may_end()) report.refusal = Refusal::security;
  return report;
}

}  // namespace vdrive::wire
