// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdrive::judge {

/// A transfer that has ended, as both sides of it have shown.
struct SdoTransfer {
  bool is_download = false;  ///< the master wrote; else it read
  ObjectAddress object;
  std::uint32_t abort = 0;           ///< the code; 0 = it succeeded
  std::vector<std::uint8_t> data{};  ///< as the object has it, little-endian
  bool is_complete = true;           ///< false: a block transfer, whose data is not kept
};

/// Looks at the default SDO channel of one node (CiA 301, 7.2.4): expedited and segmented transfers
/// both ways; block transfers are followed to their end. It takes part in nothing.
class SdoObserver {
 public:
  /// Longer data is cut [bytes]: no object of a drive profile is that long.
  static constexpr std::size_t kMostData = 1024;

  /// A frame of the master.
  /// @param frame of 8 bytes
  /// @return an abort by the master has ended this.
  std::optional<SdoTransfer> take_request(const canopen::Frame& frame);

  /// A frame of the node.
  /// @param frame of 8 bytes
  std::optional<SdoTransfer> take_response(const canopen::Frame& frame);

  /// @return the download whose last data the node has, but not confirmed: from now on it may act.
  [[nodiscard]] const SdoTransfer* pending_download() const noexcept {
    return is_sent_ ? &transfer_ : nullptr;
  }

  /// The node does not answer any more.
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
  bool is_sent_ = false;      ///< all data of a download is on the bus
  bool is_in_block_ = false;  ///< frames of the sender are segments of a block
  bool is_last_block_ = false;
};

}  // namespace vdrive::judge
