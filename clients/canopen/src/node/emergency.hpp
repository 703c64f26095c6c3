// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace vdrive::canopen {

/// The emergency producer of a node (CiA 301, 7.2.7): objects 1014h and 1015h.
///
/// | byte | of the message |
/// | --- | --- |
/// | 0 to 1 | error code; 0000h = error reset |
/// | 2 | error register 1001h |
/// | 3 to 4 | statusword 6041h |
/// | 5 | operating mode 6061h |
/// | 6 | faults of the drive since power-up, modulo 256 |
/// | 7 | heartbeat error 8130h: node id of the silent producer; otherwise 0 |
///
/// Each fault of the drive is sent once with its code 603Fh, and 0000h is sent when a fault reset
/// has cleared 603Fh. A heartbeat error lasts until all producers are heard again. A PDO or SYNC
/// error, such as 8210h, lasts until a correct frame arrives, the parameters change, or the NMT
/// state changes; 8140h ends as soon as it is sent. When the last error is over, 0000h is sent
/// unless the drive has a fault. A fault with which the drive reacts to a heartbeat error (by
/// 6007h) has the same code, 8130h: it is not sent again while the heartbeat error lasts.
///
/// 1003h records every error (CiA 301, 7.5.2.4), including those whose message the inhibit time or
/// 1014h has held back. It is cleared when the node or its drive powers up.
class Emergency {
 public:
  /// Emergencies that can wait to be sent, as many as 1003h holds. When the queue is full the
  /// oldest is dropped and counted.
  static constexpr std::size_t kMostWaiting = 8;

  /// Entries of 1003h.
  static constexpr std::size_t kMostHistory = 8;

  /// Longest wait for the drive to restart [drive time]. If it has not restarted by then, it still
  /// has its faults, and they are sent.
  static constexpr DriveTime kLongestRestart = std::chrono::seconds(1);

  /// 1014h and 1015h get their defaults. Nothing is sent until set_allowed(true).
  /// @param host outlives the producer
  Emergency(std::uint8_t node_id, NodeHost& host);

  [[nodiscard]] std::uint32_t cob_id() const noexcept { return cob_id_; }  ///< 1014h

  /// Writes 1014h. With bit 31 set no emergency is sent, and waiting ones are dropped.
  /// @return value_range_exceeded when any of bits 11 to 30 is 1, or when the value is valid (bit
  ///         31 = 0) and its CAN-ID is restricted or differs from the one that is valid now
  AbortCode set_cob_id(std::uint32_t value);

  /// 1015h [100 us]: the time between two emergencies. Those that arise within it are sent later,
  /// in order.
  [[nodiscard]] std::uint16_t inhibit_time() const noexcept { return inhibit_time_; }

  void set_inhibit_time(std::uint16_t value) noexcept { inhibit_time_ = value; }

  /// Sets 1014h and 1015h back to their defaults and forgets all errors, so that a lasting fault is
  /// sent again. Nothing is sent until set_allowed(true). A pending restart is still awaited.
  void reset();

  /// NMT reset node, after reset(): the drive is switched off and on. In real time the bench does
  /// that some ticks later, and the status until then is stale. So no fault is sent until the
  /// status shows the restart: no power and no fault since power-up, or fewer faults than before.
  /// @param drive last status before the restart
  void await_restart(const AxisStatus& drive, DriveTime now);

  /// The present drive is a different one, or has restarted.
  void forget_restart() noexcept { restart_.reset(); }

  /// Whether the NMT state allows emergencies. While it does not, they wait.
  void set_allowed(bool is_allowed, DriveTime now);

  /// The status of the drive after a tick, with 6041h as masters see it.
  void update(const AxisStatus& drive, DriveTime now);

  /// A communication error other than a silent producer has begun, such as 8210h.
  void begin_error(std::uint16_t error_code, DriveTime now);

  /// All errors of begin_error() are over. Does nothing if there are none.
  void end_errors(DriveTime now);

  void begin_heartbeat_error(std::uint8_t producer, DriveTime now);
  void end_heartbeat_error(DriveTime now);

  /// @return the bits that communication errors set in 1001h now, without those of the drive.
  [[nodiscard]] std::uint8_t error_register() const noexcept;

  /// 1003h: error codes, the newest first.
  [[nodiscard]] const std::deque<std::uint16_t>& history() const noexcept { return history_; }

  /// 0 was written to 1003h:00.
  void clear_history() noexcept { history_.clear(); }

  void advance(DriveTime now);
  [[nodiscard]] std::optional<DriveTime> next_due() const;

  /// @return the number of messages dropped so far.
  [[nodiscard]] std::uint64_t held_back() const noexcept { return waiting_.dropped(); }

 private:
  using Message = std::array<std::uint8_t, kMostData>;

  struct Cause {
    std::uint16_t error_code = 0;
    std::uint8_t producer = 0;
  };

  /// A restart that the drive has not shown yet.
  struct Restart {
    std::uint32_t faults_before = 0;
    DriveTime end{};  ///< when it is no longer awaited
  };

  [[nodiscard]] bool awaits_restart(const AxisStatus& drive, DriveTime now);
  [[nodiscard]] Message message_of(const Cause& cause) const;
  void post(const Cause& cause, DriveTime now);
  void note_end(DriveTime now);
  [[nodiscard]] DriveTime next_allowed() const;

  std::uint8_t node_id_;
  NodeHost& host_;
  std::uint32_t cob_id_ = 0;
  std::uint16_t inhibit_time_ = 0;
  bool is_allowed_ = false;
  AxisStatus drive_;
  std::optional<Restart> restart_;
  bool has_heartbeat_error_ = false;
  bool has_error_ = false;
  std::deque<std::uint16_t> history_;
  BoundedQueue<Message> waiting_{kMostWaiting, WhenFull::drops_oldest};
  std::optional<DriveTime> last_sent_;
};

}  // namespace vdrive::canopen
