// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdrive::canopen {

/// Time of those who wait for others on the bus: real time since any beginning that stays, also
/// while the drive time of a bench stands.
using BusTime = std::chrono::microseconds;

/// What became of a transfer.
struct SdoOutcome {
  AbortCode abort = AbortCode::none;  ///< sent by either side; of another maker's node any number
  std::vector<std::uint8_t> data{};   ///< that was read

  friend bool operator==(const SdoOutcome&, const SdoOutcome&) = default;
};

/// What puts frames on a bus.
class FrameSender {
 public:
  virtual ~FrameSender() = default;

  virtual void send(const Frame& frame) = 0;
};

/// SDO client (CiA 301, 7.2.4) for the default SDO channel of one node: requests on 600h + node id,
/// answers on 580h + node id; expedited and segmented transfers, one at a time. A function of
/// frames and time.
class SdoClient final {
 public:
  /// A longer value is refused with out_of_memory [bytes].
  static constexpr std::size_t kLongestValue = 65'536;

  /// @param node_id 1 to 127
  /// @param sender outlives the client; called within a call of it, calls none of it
  SdoClient(std::uint8_t node_id, FrameSender& sender) : node_id_(node_id), sender_(sender) {}

  /// Begins to read an object ("SDO upload").
  /// @param time_out for each answer of the node
  /// @pre no transfer is under way, and the outcome of the one before was taken
  void read(ObjectAddress object, std::chrono::milliseconds time_out, BusTime now);

  /// Begins to write an object ("SDO download"): up to 4 bytes expedited, others in segments.
  /// @param data as the object has it, little-endian
  /// @pre as read()
  void write(ObjectAddress object, std::vector<std::uint8_t> data,
             std::chrono::milliseconds time_out, BusTime now);

  /// Ends the transfer under way, if there is one, and tells the node why. It has no outcome.
  void cancel(AbortCode reason);

  /// Whether `frame` may be an answer to this client.
  [[nodiscard]] bool is_for(const Frame& frame) const noexcept;

  /// Takes a frame of the bus. What does not belong to the transfer under way is ignored.
  void receive(const Frame& frame, BusTime now);

  /// Ends a transfer whose answer is overdue, with protocol_timed_out.
  void advance(BusTime now);

  /// @return when the answer is overdue; nothing while no transfer is under way.
  [[nodiscard]] std::optional<BusTime> next_due() const noexcept;

  /// @return what became of the transfer, once.
  [[nodiscard]] std::optional<SdoOutcome> take_outcome();

 private:
  enum class Step : std::uint8_t { idle, read_start, read_segment, write_start, write_segment };

  void begin(Step step, ObjectAddress object, std::chrono::milliseconds time_out, BusTime now);
  [[nodiscard]] bool has_multiplexer(const Frame& frame) const noexcept;
  [[nodiscard]] Frame initiate(std::uint32_t command) const noexcept;
  void on_read_started(const Frame& frame, BusTime now);
  void on_read_segment(const Frame& frame, BusTime now);
  void on_write_started(const Frame& frame, BusTime now);
  void on_write_segment(const Frame& frame, BusTime now);
  void request_segment(BusTime now);
  void send_segment(BusTime now);
  bool is_toggle_right(std::uint32_t command);
  void send_request(const Frame& frame, BusTime now);
  void finish(AbortCode abort);
  void break_off(AbortCode reason);
  void send_abort(AbortCode reason) const;

  std::uint8_t node_id_;
  FrameSender& sender_;
  Step step_ = Step::idle;
  ObjectAddress object_{};
  std::vector<std::uint8_t> data_;       ///< to write, or read so far
  std::size_t position_ = 0;             ///< bytes that were sent
  std::optional<std::uint32_t> size_{};  ///< that the node has announced [bytes]
  bool toggle_ = false;
  std::chrono::milliseconds time_out_{};
  BusTime due_{};
  std::optional<SdoOutcome> outcome_{};
};

}  // namespace vdrive::canopen
