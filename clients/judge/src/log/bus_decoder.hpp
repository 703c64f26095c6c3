// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/record.hpp"
#include "log/logged_pdo.hpp"
#include "log/sdo_observer.hpp"
#include "node/data_sheet_reader.hpp"
#include "node/frame.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::judge {

/// The kind of a frame on a CANopen bus.
enum class FrameKind : std::uint8_t {
  nmt,
  sync,
  emergency,
  time_stamp,
  transmit_pdo,
  receive_pdo,
  sdo_response,
  sdo_request,
  heartbeat,
  lss,
  foreign,  ///< none of these
};

/// @return such as "nmt" or "receive_pdo".
[[nodiscard]] std::string_view to_string(FrameKind kind) noexcept;

struct DecodedFrame {
  FrameKind kind = FrameKind::foreign;
  std::uint8_t node = 0;         ///< 0 = all, or none
  std::uint16_t pdo_number = 0;  ///< of a PDO, from 1
};

struct DecoderSettings {
  std::set<std::uint8_t> nodes{};             ///< to judge; empty = every drive on the bus
  const canopen::DataSheet* sheet = nullptr;  ///< of these nodes; must outlive the decoder
};

/// Counts of all frames, and of the kinds of frames that were not judged.
struct DecoderCounts {
  std::uint64_t frames = 0;
  std::uint64_t foreign = 0;          ///< not CANopen in the predefined connection set
  std::uint64_t other_nodes = 0;      ///< of nodes that are not judged
  std::uint64_t malformed = 0;        ///< CANopen with a wrong length or content
  std::uint64_t unknown_mapping = 0;  ///< PDOs with unknown content
};

/// Converts the frames of a CANopen bus to records: NMT, SYNC, emergencies, heartbeats, SDO
/// transfers, and PDOs. The PDO mapping comes from the traffic, a data sheet or CiA 402. Depends
/// only on frames and times. Record::axis is the node id.
///
/// A node counts as a drive once 6040h was written to it or it has shown 6041h; earlier records are
/// kept until then. A device whose 1000h names another profile is not a drive.
class BusDecoder {
 public:
  using Sink = std::function<void(const Record& record)>;

  BusDecoder(DecoderSettings settings, Sink sink);
  ~BusDecoder();
  BusDecoder(const BusDecoder&) = delete;
  BusDecoder& operator=(const BusDecoder&) = delete;

  /// @param now not earlier than for the previous frame
  /// @param line of the log, from 1; 0 = none
  /// @return the kind of the frame
  DecodedFrame take(Time now, const canopen::Frame& frame, std::uint64_t line = 0);

  /// Records that an unknown number of frames is missing.
  void lose(Time now);

  /// Ends the decoding.
  /// @param now time of the last frame
  void end(Time now);

  [[nodiscard]] const DecoderCounts& counts() const noexcept { return counts_; }

  /// @return what is unknown or was assumed, one per line.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  struct Node;

  Node& node_of(std::uint8_t number);
  [[nodiscard]] bool is_wanted(std::uint8_t number) const;
  [[nodiscard]] DecodedFrame classify(const canopen::Frame& frame) const;
  void index_pdos(std::uint8_t number);

  void take_nmt(Time now, const canopen::Frame& frame);
  void take_heartbeat(Time now, std::uint8_t number, const canopen::Frame& frame);
  void take_emergency(Time now, Node& node, const canopen::Frame& frame);
  void take_pdo(Time now, Node& node, const PdoRef& ref, const canopen::Frame& frame);
  void take_receive_pdo(Time now, Node& node, const PdoRef& ref, const LoggedPdo& pdo,
                        const canopen::Frame& frame);
  void apply_synchronous(Time now, Node& node);
  void take_transmit_pdo(Time now, Node& node, const LoggedPdo& pdo, const canopen::Frame& frame);
  void take_sdo(Time now, Node& node, const canopen::Frame& frame, bool is_request);
  void finish_sdo(Time now, Node& node, const SdoTransfer& transfer);
  void learn(Node& node, ObjectAddress object, std::int64_t value);
  void restart(Time now, Node& node, bool is_command);

  void put(Time now, Node& node, const decltype(Record::what)& what);
  void pass(Node& node, const Record& record);
  void release(Node& node);
  [[nodiscard]] std::int64_t value_of(ObjectAddress object,
                                      std::span<const std::uint8_t> bytes) const;

  DecoderSettings settings_;
  Sink sink_;
  DecoderCounts counts_;
  std::map<std::uint8_t, Node> nodes_;
  std::array<std::vector<PdoRef>, canopen::kHighestBaseId + 1> pdos_;
  std::uint32_t sync_id_;
  std::uint64_t line_ = 0;  ///< of the present frame
};

}  // namespace vdrive::judge
