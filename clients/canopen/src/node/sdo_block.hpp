// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// SDO block transfer after its initiate request, on the server's side (CiA 301, 7.2.4.3.9 to
/// 7.2.4.3.16): segments of 7 bytes, of which up to 127 form a block with one confirmation.

// Abort codes specific to block transfer (CiA 301, 7.2.4.3.17).
inline constexpr AbortCode kInvalidBlockSize{0x05040002};
inline constexpr AbortCode kInvalidSequenceNumber{0x05040003};
inline constexpr AbortCode kCrcError{0x05040004};

/// @return the CRC of block transfer: polynomial 1021h, initial value 0; "123456789" gives 31C3h.
[[nodiscard]] std::uint16_t sdo_crc(std::string_view data) noexcept;

/// The most segments in a block.
inline constexpr std::uint8_t kMostSegments = 127;

/// The effect of a request on a transfer.
struct SdoBlockStep {
  AbortCode abort = AbortCode::none;  ///< the transfer has failed
  bool is_complete = false;           ///< upload: it has ended; download: data() is the received
                                      ///< data
};

/// The terms of a client's initiate request.
struct SdoBlockTerms {
  std::uint8_t segments = kMostSegments;  ///< per block of an upload, 1 to kMostSegments
  bool has_crc = false;
};

/// The server sends data in blocks. Segments that the client has missed are repeated in the next
/// block.
class SdoBlockUpload final {
 public:
  /// @param host outlives this object
  SdoBlockUpload(std::uint8_t node_id, NodeHost& host, std::string data,
                 const SdoBlockTerms& terms);

  /// Start, confirmation of a block, or confirmation of the end.
  [[nodiscard]] SdoBlockStep receive(const Frame& request);

 private:
  enum class Phase : std::uint8_t { begun, in_block, ended };

  void send_block();
  void send_end();
  [[nodiscard]] SdoBlockStep take_confirmation(const Frame& request);

  std::uint8_t node_id_;
  NodeHost& host_;
  std::string data_;
  SdoBlockTerms terms_;
  Phase phase_ = Phase::begun;
  std::size_t confirmed_ = 0;  ///< bytes received by the client
  std::uint8_t sent_ = 0;      ///< segments of the current block
};

/// The server receives data in blocks.
class SdoBlockDownload final {
 public:
  /// @param host outlives this object
  /// @param size of the object [bytes]
  SdoBlockDownload(std::uint8_t node_id, NodeHost& host, std::size_t size, bool has_crc);

  /// A segment while is_in_block(), otherwise the end of the transfer.
  [[nodiscard]] SdoBlockStep receive(const Frame& request);

  /// @return whether the next frame is a segment whatever its first byte; only 80h is an abort.
  [[nodiscard]] bool is_in_block() const noexcept { return is_in_block_; }

  [[nodiscard]] const std::string& data() const noexcept { return data_; }

 private:
  [[nodiscard]] SdoBlockStep take_segment(const Frame& segment);
  [[nodiscard]] SdoBlockStep take_end(const Frame& request);

  std::uint8_t node_id_;
  NodeHost& host_;
  std::size_t size_;
  bool has_crc_;
  std::string data_;        ///< the unused bytes of the last segment are removed at the end
  std::uint8_t taken_ = 0;  ///< segments received in order in the current block
  bool is_in_block_ = true;
};

}  // namespace vdrive::canopen
