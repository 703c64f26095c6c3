// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace vdrive::judge {

/// The input of the judge: a sequence of writes by a master and states shown by a drive. An adapter
/// makes it from a journal, a bus log or a running bench.

/// Time since a fixed origin: by the clock of a log, in drive time for a journal.
using Time = std::chrono::nanoseconds;

/// How a write reached the drive.
enum class Channel : std::uint8_t {
  sdo,      ///< acyclic, on a CAN bus
  pdo,      ///< cyclic or event-driven, on a CAN bus: it repeats unchanged values
  request,  ///< acyclic, on a bench
  frame,    ///< of set-points, on a bench
};

/// The result of a write.
enum class Fate : std::uint8_t {
  accepted,
  refused,     ///< with an abort code
  ignored,     ///< by the rules of the drive: a set-point that it could not take
  late,        ///< it arrived after the time for which it was meant
  unanswered,  ///< the source contains no answer; it counts as accepted
};

/// An object written by a master. Of writes that arrive together, 6040h is the last one.
struct Write {
  ObjectAddress object;
  std::int64_t value = 0;
  Channel channel = Channel::request;
  Fate fate = Fate::accepted;
  std::uint32_t code = 0;    ///< of a refusal: the abort code (CiA 301)
  std::uint64_t writer = 0;  ///< session on a bench, number of an RPDO; 0 = unknown
};

/// The value of an object that a master has learned by reading it, or that the source knows.
struct Reading {
  ObjectAddress object;
  std::int64_t value = 0;
  std::uint32_t code = 0;        ///< of a refusal
  bool is_of_the_master = true;  ///< the master asked; false = the source knows the value
};

/// The members that a `Shown` can contain.
struct ShownMember {
  static constexpr std::uint16_t kStatusword = 1U << 0U;
  static constexpr std::uint16_t kMode = 1U << 1U;
  static constexpr std::uint16_t kPosition = 1U << 2U;
  static constexpr std::uint16_t kDemand = 1U << 3U;
  static constexpr std::uint16_t kFollowingError = 1U << 4U;
  static constexpr std::uint16_t kTorque = 1U << 5U;
  static constexpr std::uint16_t kErrorCode = 1U << 6U;
};

/// The state that a drive showed at one moment.
struct Shown {
  std::uint16_t members = 0;
  std::uint16_t statusword = 0;      ///< 6041h
  std::uint16_t error_code = 0;      ///< 603Fh
  std::int16_t torque = 0;           ///< 6077h [‰ of rated torque]
  std::int32_t position = 0;         ///< 6064h [user units]
  std::int32_t demand = 0;           ///< 6062h [user units]
  std::int32_t following_error = 0;  ///< 60F4h [user units]
  std::int8_t mode = 0;              ///< 6061h
  bool is_asked_for = false;  ///< the master read it; otherwise the drive sends each change unasked

  [[nodiscard]] bool has(std::uint16_t member) const noexcept { return (members & member) != 0; }

  friend bool operator==(const Shown&, const Shown&) = default;
};

/// State of a node on a bus (CiA 301, NMT state machine).
enum class NodeState : std::uint8_t { initialising, pre_operational, operational, stopped };

/// A node changes its state, or reports it.
struct Network {
  NodeState state = NodeState::operational;
  bool is_command = false;  ///< by the NMT master; otherwise reported by the node
};

/// SYNC on the bus of the axis.
struct Sync {};

/// An emergency message of the drive.
struct Emergency {
  std::uint16_t code = 0;
};

/// A PDO for the drive has arrived. The writes that it carries follow.
struct ReceivePdo {
  std::uint16_t number = 1;            ///< from 1
  std::optional<std::uint8_t> type{};  ///< transmission type, if known
};

/// A sign of life of the master; the drive waits for the next one no longer than `limit`.
struct KeepAlive {
  Time limit{};
};

/// The source has lost records at this point: states may have changed unseen.
struct Gap {
  std::string_view cause = "gap in the source";  ///< static
};

struct Record {
  Time time{};
  std::uint64_t tick = 0;  ///< of a bench; 0 = none
  std::uint64_t line = 0;  ///< of a log, from 1; 0 = none
  std::uint32_t axis = 0;  ///< any constant number, such as a node id
  std::variant<Write, Shown, Reading, Network, Sync, Emergency, ReceivePdo, KeepAlive, Gap> what;
};

}  // namespace vdrive::judge
