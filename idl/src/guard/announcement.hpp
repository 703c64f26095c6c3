// SPDX-License-Identifier: Apache-2.0
// What participants announce of themselves, as it is read and changed before the library reads it.
#pragma once

#include "rtps.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::wire {

/// The lease that the library reads of every participant. Its timer of a lease must not fire beside
/// a removal (Fast DDS 2.9.1 and 3.1.2, PDP::check_remote_participant_liveliness aborts), so that
/// it is longer than any service runs between two checks; the guard judges who is gone.
constexpr std::chrono::seconds kLeaseForTheLibrary = std::chrono::hours{24};

enum class Announcer : std::uint8_t {
  foreign,         ///< no participant of vdrive
  vdrive,          ///< its name begins with "vdrive"
  vdrive_visitor,  ///< "vdrive client" or "vdrive probe"
};

struct Announcement {
  GuidPrefix participant{};
  std::chrono::milliseconds lease{0};  ///< max() when it has no end
  bool gone = false;  ///< it has left, by its own announcement or by that of another
  /// Who leaves is in the key of the inline QoS; Fast DDS 2.9 does not see it in the content, where
  /// Cyclone DDS has it.
  bool library_knows_key = false;
  Announcer announcer = Announcer::foreign;
  bool is_closed = false;  ///< it has DDS Security
};

/// Reads the announcement in a DATA submessage of a datagram that passed the check.
/// @return nothing when it does not name its participant, or has no lease although it does not
/// leave.
[[nodiscard]] std::optional<Announcement> read_announcement(const Submessage& submessage,
                                                            const DataSubmessage& data) noexcept;

/// Writes kLeaseForTheLibrary into every lease of a list of parameters.
/// @param list the list and nothing behind it, see list_in; changed in place
void raise_leases(std::span<std::uint8_t> list, bool little) noexcept;

/// Makes the library skip the types' descriptions in a list of parameters. Fast DDS 2.9 builds
/// types from them without a check, and follows a null pointer where it knows none of these
/// types. 3.1 would ask the announcer for them before it matches the endpoint.
/// @param list as of raise_leases
void hide_types(std::span<std::uint8_t> list, bool little) noexcept;

/// @return a datagram by which the participant `gone` leaves, as Fast DDS itself sends one: DATA of
///         the announcing entity with the key and the status "disposed and unregistered". Its
///         sequence number is above all that the participant can have sent: a reader takes nothing
///         older, and believes only the writer itself. The library forgets the number with the
///         participant, so that one that only stood still is found again.
[[nodiscard]] std::vector<std::uint8_t> end_datagram(const GuidPrefix& gone);

}  // namespace vdrive::wire
