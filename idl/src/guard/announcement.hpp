// SPDX-License-Identifier: Apache-2.0
// The announcements of participants, read and changed before the library reads them.
#pragma once

#include "rtps.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::wire {

/// The lease that the library reads for every participant. A lease timer of the library must not
/// fire during a removal (Fast DDS 2.9.1 and 3.1.2: PDP::check_remote_participant_liveliness
/// aborts), so the lease is too long to end before the guard decides who is gone.
constexpr std::chrono::seconds kLeaseForTheLibrary = std::chrono::hours{24};

enum class Announcer : std::uint8_t {
  foreign,         ///< not a vdrive participant
  vdrive,          ///< its name starts with "vdrive"
  vdrive_visitor,  ///< "vdrive client" or "vdrive probe"
};

struct Announcement {
  GuidPrefix participant{};
  std::chrono::milliseconds lease{0};  ///< max() if it never ends
  bool gone = false;  ///< it has left, announced by itself or by another participant
  /// Whether the leaving participant is in the key of the inline QoS. Cyclone DDS puts it in the
  /// content, where Fast DDS 2.9 does not see it.
  bool library_knows_key = false;
  Announcer announcer = Announcer::foreign;
  bool is_closed = false;  ///< it uses DDS Security
};

/// Reads the announcement in a DATA submessage of a datagram that has passed the check.
/// @return nothing if it does not identify its participant, or has no lease although the
///         participant is not leaving.
[[nodiscard]] std::optional<Announcement> read_announcement(const Submessage& submessage,
                                                            const DataSubmessage& data) noexcept;

/// Writes kLeaseForTheLibrary into every lease of a parameter list.
/// @param list exactly the list, see list_in; changed in place
void raise_leases(std::span<std::uint8_t> list, bool little) noexcept;

/// Makes the library skip the type descriptions in a parameter list. Fast DDS 2.9 builds types from
/// them without a check, and dereferences a null pointer if it knows none of these types. 3.1 would
/// request them from the announcer before it matches the endpoint.
/// @param list as in raise_leases
void hide_types(std::span<std::uint8_t> list, bool little) noexcept;

/// @return a datagram that announces that `gone` has left, as Fast DDS itself sends it: DATA of the
///         announcing writer with the key and the status "disposed and unregistered". Only that
///         writer is believed. The sequence number is higher than any that it can have sent,
///         because a reader ignores lower ones. The library forgets the number together with the
///         participant, so that a participant that was only suspended is found again.
[[nodiscard]] std::vector<std::uint8_t> end_datagram(const GuidPrefix& gone);

}  // namespace vdrive::wire
