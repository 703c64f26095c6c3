// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdrive::judge {

/// A completed transfer, as seen from both sides.
struct SdoTransfer {
  bool is_download = false;  ///< the master wrote; otherwise it read
  ObjectAddress object;
  std::uint32_t abort = 0;           ///< the code; 0 = it succeeded
  std::vector<std::uint8_t> data{};  ///< as stored in the object, little-endian
  bool is_complete = true;           ///< false for a block transfer, whose data is not kept
};

/// Observes the default SDO channel of one node (CiA 301, 7.2.4): expedited and segmented transfers
/// in both directions; block transfers are followed to their end. Does not take part in the
/// traffic.
class SdoObserver {
 public:
  /// Longer data is truncated [bytes]: no object of a drive profile is that long.
  static constexpr std::size_t kMostData = 1024;

  /// Processes a frame of the master.
  /// @param frame of 8 bytes
  /// @return the transfer, if the master has ended it by an abort.
  std::optional<SdoTransfer> take_request(const canopen::Frame& frame);

  /// Processes a frame of the node.
  /// @param frame of 8 bytes
  std::optional<SdoTransfer> take_response(const canopen::Frame& frame);

  /// @return the download that the node has received completely but not confirmed: it may already
  ///         act on it.
  [[nodiscard]] const SdoTransfer* pending_download() const noexcept {
    return is_sent_ ? &transfer_ : nullptr;
  }

  /// Drops the present transfer when the node no longer answers.
  void forget() noexcept;

 private:
  enum class Step : std::uint8_t { idle, download, upload, block_download, block_upload };

  void begin(Step step, const canopen::Frame& frame);
  void put(const canopen::Frame& frame, std::size_t first, std::size_t count);
  void begin_download(const canopen::Frame& frame);
  void begin_block_upload(const canopen::Frame& frame);
  std::optional<SdoTransfer> take_abort(const canopen::Frame& frame);
  std::optional<SdoTransfer> take_upload(const canopen::Frame& frame);
  std::optional<SdoTransfer> take_block_upload(const canopen::Frame& frame);
  std::optional<SdoTransfer> finish();

  Step step_ = Step::idle;
  SdoTransfer transfer_;
  bool is_sent_ = false;      ///< all data of a download has been sent
  bool is_in_block_ = false;  ///< frames from the sender are segments of a block
  bool is_last_block_ = false;
};

}  // namespace vdrive::judge
