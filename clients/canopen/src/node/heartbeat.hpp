// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/node_settings.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdrive::canopen {

/// The heartbeat producer of a node, with its boot-up message (CiA 301, 7.2.8.3.2.2 and 7.2.8.3.3):
/// object 1017h.
class HeartbeatProducer {
 public:
  /// 1017h gets its default.
  /// @param host outlives the producer
  HeartbeatProducer(std::uint8_t node_id, NodeHost& host);

  [[nodiscard]] std::uint16_t time() const noexcept { return time_; }  ///< 1017h [ms]; 0 = none

  /// Writes 1017h. Unless it is 0, the first heartbeat is due immediately.
  void set_time(std::uint16_t milliseconds, DriveTime now);

  /// Sets 1017h back to its default. Nothing is due until boot_up().
  void reset();

  /// Sends the boot-up message, which counts as the first heartbeat.
  void boot_up(DriveTime now);

  /// Sends the heartbeat when it is due. A late call does not shift the later heartbeats, unless it
  /// is late by at least one period.
  void advance(NmtState state, DriveTime now);

  [[nodiscard]] std::optional<DriveTime> next_due() const noexcept { return next_; }

 private:
  [[nodiscard]] DriveTime period() const noexcept;
  void send(NmtState state);

  std::uint8_t node_id_;
  NodeHost& host_;
  std::uint16_t time_ = 0;
  std::optional<DriveTime> next_;
};

/// The heartbeat consumer of a node (CiA 301, 7.2.8.2.2 and 7.5.2.19): object 1016h.
///
/// A producer is monitored from its first heartbeat on. Its boot-up message counts as a heartbeat,
/// so a producer that lost its 1017h in a reset is reported one consumer time later.
class HeartbeatConsumer {
 public:
  static constexpr std::size_t kEntries = 4;

  /// 1016h gets its defaults.
  HeartbeatConsumer();

  /// @param subindex of 1016h, 1 to kEntries
  [[nodiscard]] std::uint32_t entry(std::uint8_t subindex) const;

  /// Writes 1016h: the producer's node id in bits 16 to 23, the time [ms] in bits 0 to 15. An entry
  /// is unused if either is 0. The entry waits for a first heartbeat again.
  /// @param subindex 1 to kEntries
  /// @return value_range_exceeded when any of bits 24 to 31 is 1; parameter_incompatibility when
  ///         another entry monitors the same producer
  AbortCode set_entry(std::uint8_t subindex, std::uint32_t value);

  /// Sets 1016h back to its defaults.
  void reset();

  /// A heartbeat or boot-up message of a node has arrived.
  void receive(std::uint8_t producer, DriveTime now);

  /// @return the node id of a producer that has exceeded its consumer time, each once; none = no
  ///         further one.
  std::optional<std::uint8_t> take_silent(DriveTime now);

  /// @return whether a producer is silent: take_silent() has returned it, and it has not been heard
  ///         since.
  [[nodiscard]] bool has_silent() const;

  [[nodiscard]] std::optional<DriveTime> next_due() const;

 private:
  struct Entry {
    std::uint32_t value = 0;
    std::optional<DriveTime> deadline{};  ///< of the next heartbeat; none = not monitored yet
    bool is_silent = false;

    [[nodiscard]] std::uint8_t producer() const noexcept;
    [[nodiscard]] DriveTime time() const noexcept;
    [[nodiscard]] bool is_used() const noexcept;
  };

  std::array<Entry, kEntries> entries_;
};

}  // namespace vdrive::canopen
