// SPDX-License-Identifier: Apache-2.0
#include "announcement.hpp"

#include <algorithm>
#include <limits>
#include <string_view>

namespace vdrive::wire {
namespace {

constexpr std::uint32_t kEndless = 0x7FFFFFFF;  // [s]; longer leases do not end either

std::chrono::milliseconds lease_of(ByteView value, bool little) {
  ByteReader reader(value, little);
  const std::uint32_t seconds = reader.u32();
  const std::uint64_t fraction = reader.u32();
  if (seconds >= kEndless) return std::chrono::milliseconds::max();
  return std::chrono::seconds{seconds} + std::chrono::milliseconds{(fraction * 1000U) >> 32U};
}

Announcer announcer_of(ByteView value, bool little) {
  ByteReader reader(value, little);
  const std::size_t length = reader.u32();
  constexpr std::size_t kLongest = 16;  // more than any name that is checked for
  std::array<char, kLongest> start{};
  const ByteView text = value.subspan(4, std::min(length, kLongest));
  std::ranges::copy(text, start.begin());
  const std::string_view name(start.data(), text.size());
  if (name.starts_with("vdrive client") || name.starts_with("vdrive probe")) {
    return Announcer::vdrive_visitor;
  }
  return name.starts_with("vdrive") ? Announcer::vdrive : Announcer::foreign;
}

/// @return the participant identified by the key in the inline QoS.
std::optional<GuidPrefix> key_of_announced(const Submessage& submessage,
                                           const DataSubmessage& data) {
  ParameterList list(data.inline_qos, submessage.has(kLittle));
  for (ListEntry entry; list.next(entry);) {
    GuidPrefix prefix{};
    if (entry.id == kKeyHash && entry.value.size() >= prefix.size()) {
      std::copy_n(entry.value.begin(), prefix.size(), prefix.begin());
      return prefix;
    }
  }
  return std::nullopt;
}

/// @return the participant identified by the content.
std::optional<GuidPrefix> guid_of(const DataSubmessage& data) {
  ParameterList list(data.list(), data.list_is_little());
  for (ListEntry entry; list.next(entry);) {
    GuidPrefix prefix{};
    if (entry.id == kParticipantGuid && entry.value.size() >= prefix.size()) {
      std::copy_n(entry.value.begin(), prefix.size(), prefix.begin());
      return prefix;
    }
  }
  return std::nullopt;
}

template <typename Change>
void for_each_entry(std::span<std::uint8_t> bytes, bool little, const Change& change) {
  constexpr std::size_t kHeader = 4;
  ParameterList list(bytes, little);
  for (ListEntry entry; list.next(entry);) {
    change(entry, bytes.subspan(entry.offset, kHeader + entry.value.size()));
  }
}

std::optional<Announcement> read_departure(const Submessage& submessage,
                                           const DataSubmessage& data) {
  const auto key = key_of_announced(submessage, data);
  const auto content = data.is_list() ? guid_of(data) : std::nullopt;
  if (!key && !content) return std::nullopt;
  Announcement announcement;
  announcement.gone = true;
  announcement.library_knows_key = key.has_value();
  announcement.participant = key ? *key : *content;
  return announcement;
}

}  // namespace

std::optional<Announcement> read_announcement(const Submessage& submessage,
                                              const DataSubmessage& data) noexcept {
  if (!submessage.has(kThird)) return read_departure(submessage, data);
  Announcement announcement;
  const bool little = data.list_is_little();
  bool has_guid = false;
  bool has_lease = false;
  ParameterList list(data.list(), little);
  for (ListEntry entry; list.next(entry);) {
    if (entry.id == kParticipantGuid) {
      std::copy_n(entry.value.begin(), announcement.participant.size(),
                  announcement.participant.begin());
      has_guid = true;
    } else if (entry.id == kLease) {
      announcement.lease = lease_of(entry.value, little);
      has_lease = true;
    } else if (entry.id == kEntityName) {
      announcement.announcer = announcer_of(entry.value, little);
    } else if (entry.id == kParticipantSecurity) {
      announcement.is_closed = true;
    }
  }
  return has_guid && has_lease ? std::optional(announcement) : std::nullopt;
}

void raise_leases(std::span<std::uint8_t> list, bool little) noexcept {
  constexpr std::size_t kLeaseSize = 8;
  for_each_entry(list, little, [little](const ListEntry& entry, std::span<std::uint8_t> place) {
    if (entry.id == kLease && entry.value.size() >= kLeaseSize) {
      put_u32(place.subspan(4), static_cast<std::uint32_t>(kLeaseForTheLibrary.count()), little);
      put_u32(place.subspan(8), 0, little);
    }
  });
}

void hide_types(std::span<std::uint8_t> list, bool little) noexcept {
  for_each_entry(list, little, [](const ListEntry& entry, std::span<std::uint8_t> place) {
    if (entry.id == kTypeId || entry.id == kTypeObject || entry.id == kTypeInformation) {
      place[0] = 0;  // kPad, which is skipped
      place[1] = 0;
    }
  });
}

std::vector<std::uint8_t> end_datagram(const GuidPrefix& gone) {
  std::vector<std::uint8_t> datagram{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  const auto add = [&datagram](std::initializer_list<std::uint8_t> bytes) {
    datagram.insert(datagram.end(), bytes);
  };
  datagram.insert(datagram.end(), gone.begin(), gone.end());
  add({0x15, 3, 52, 0, 0, 0, 16, 0});         // DATA, little endian, with inline QoS
  add({0, 1, 0, 0xC7, 0, 1, 0, 0xC2});        // from and to discovery
  add({0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0x7F});  // sequence number 2^31 - 1
  add({0x70, 0, 16, 0});                      // key
  datagram.insert(datagram.end(), gone.begin(), gone.end());
  add({0, 0, 1, 0xC1});
  add({0x71, 0, 4, 0, 0, 0, 0, 3});  // status: disposed and unregistered
  add({1, 0, 0, 0});
  return datagram;
}

}  // namespace vdrive::wire
