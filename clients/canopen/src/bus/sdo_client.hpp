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

/// Time for time-outs on the bus: wall time from an arbitrary fixed origin. It runs even while the
/// drive time of a bench stands still.
using BusTime = std::chrono::microseconds;

/// The outcome of a transfer.
struct SdoOutcome {
  AbortCode abort = AbortCode::none;  ///< sent by either side; nodes of other makers may send any
                                      ///< number
  std::vector<std::uint8_t> data{};   ///< data read

  friend bool operator==(const SdoOutcome&, const SdoOutcome&) = default;
};

/// Sends frames on a bus.
class FrameSender {
 public:
  virtual ~FrameSender() = default;

  virtual void send(const Frame& frame) = 0;
};

/// An SDO client (CiA 301, 7.2.4) for the default SDO channel of one node: requests on 600h + node
/// id, answers on 580h + node id; expedited and segmented transfers, one at a time. A function of
/// frames and time.
class SdoClient final {
 public:
  /// The largest value [bytes]; a larger one is refused with out_of_memory.
  static constexpr std::size_t kLongestValue = 65'536;

  /// @param node_id 1 to 127
  /// @param sender outlives the client; called within a call of the client, and must not call it
  SdoClient(std::uint8_t node_id, FrameSender& sender) : node_id_(node_id), sender_(sender) {}

  /// Begins to read an object ("SDO upload").
  /// @param time_out for each answer of the node
  /// @pre no transfer is active, and the outcome of the previous one was taken
  void read(ObjectAddress object, std::chrono::milliseconds time_out, BusTime now);

  /// Begins to write an object ("SDO download"): up to 4 bytes expedited, more in segments.
  /// @param data the value, little-endian
  /// @pre as read()
  void write(ObjectAddress object, std::vector<std::uint8_t> data,
             std::chrono::milliseconds time_out, BusTime now);

  /// Ends the active transfer, if any, without an outcome, and sends the reason to the node.
  void cancel(AbortCode reason);

  /// @return whether `frame` may be an answer to this client.
  [[nodiscard]] bool is_for(const Frame& frame) const noexcept;

  /// Takes a frame of the bus. Frames that do not belong to the active transfer are ignored.
  void receive(const Frame& frame, BusTime now);

  /// Ends a transfer whose answer is overdue, with protocol_timed_out.
  void advance(BusTime now);

  /// @return when the answer is overdue; nothing if no transfer is active.
  [[nodiscard]] std::optional<BusTime> next_due() const noexcept;

  /// @return the outcome of the transfer, once.
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
  std::size_t position_ = 0;             ///< bytes sent
  std::optional<std::uint32_t> size_{};  ///< announced by the node [bytes]
  bool toggle_ = false;
  std::chrono::milliseconds time_out_{};
  BusTime due_{};
  std::optional<SdoOutcome> outcome_{};
};

}  // namespace vdrive::canopen
