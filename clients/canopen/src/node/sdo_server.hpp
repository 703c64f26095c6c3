// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/sdo_block.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>

namespace vdrive::canopen {

/// The requirements for a download to an object.
struct SdoTarget {
  AbortCode abort = AbortCode::none;  ///< why the object cannot be written
  std::uint8_t size = 0;              ///< [bytes], 1 to 4
};

/// The result of an access to an object.
struct SdoAnswer {
  AbortCode abort = AbortCode::none;
  std::string bytes{};   ///< upload: least significant byte first
  bool is_text = false;  ///< sent in segments; a number is sent in the response (expedited)
};

/// The objects that an SDO server gives access to. Functions are called within a call of the server
/// and must not call it.
class SdoObjects {
 public:
  virtual ~SdoObjects() = default;

  [[nodiscard]] virtual SdoTarget check_download(ObjectAddress object) const = 0;

  /// @return the answer; none = SdoServer::finish() delivers it later. Until then no other access
  ///         begins.
  virtual std::optional<SdoAnswer> begin_upload(ObjectAddress object) = 0;

  /// @param data of the size that check_download() returned
  /// @return as begin_upload()
  virtual std::optional<SdoAnswer> begin_download(ObjectAddress object,
                                                  std::span<const std::uint8_t> data,
                                                  DriveTime now) = 0;
};

struct SdoCounters {
  std::uint64_t aborts = 0;     ///< sent by the server, including time-outs
  std::uint64_t time_outs = 0;  ///< transfers that the client did not continue
};

/// The SDO server of a node with the default COB-IDs 600h and 580h + node id (CiA 301, 7.2.4):
/// expedited, segmented and block transfers in both directions.
///
/// Each request gets one response or abort, in the order of the requests. Block transfer is the
/// exception: a block of segments gets one response, and a response may be a block of segments.
///
/// | request | answer |
/// | --- | --- |
/// | initiate, at any time | starts a new transfer; the current one ends without an answer |
/// | segment of no transfer, or of the other direction | abort 05040001h |
/// | specifier 7, and anything that a block transfer does not expect | abort 05040001h |
/// | any frame but 80h within a block of a download | it is taken as a segment |
/// | block size 0 or above 127 segments | abort 05040002h |
/// | segment 0, or confirmation of more than was sent | abort 05040003h |
/// | wrong CRC of a block download | abort 05040004h |
/// | segment whose toggle bit does not alternate | abort 05030000h |
/// | more data than the object has | abort 06070012h, as soon as it is known |
/// | less data | abort 06070013h |
/// | any, while an access to the drive is pending | waits; beyond kMostWaiting: abort 05040005h |
/// | abort by the client | none; ends the transfer, and waiting requests are dropped |
///
/// An abort ends the transfer. A client that does not continue a transfer within kClientTimeOut
/// gets abort 05040000h.
class SdoServer {
 public:
  static constexpr DriveTime kClientTimeOut = std::chrono::seconds{1};
  static constexpr std::size_t kMostWaiting = 16;

  /// @param host outlives the server
  /// @param objects outlive the server
  SdoServer(std::uint8_t node_id, NodeHost& host, SdoObjects& objects);

  /// @param request a data frame of 8 bytes
  void receive(const Frame& request, DriveTime now);

  /// The answer to the pending access; ignored if there is none.
  void finish(const SdoAnswer& answer, DriveTime now);

  /// The NMT state no longer allows SDO: nothing pending is answered. A new access waits until the
  /// pending one has ended.
  void stop();

  /// As stop(), and forgets the pending access too.
  void reset();

  void advance(DriveTime now);
  [[nodiscard]] std::optional<DriveTime> next_due() const;

  [[nodiscard]] const SdoCounters& counters() const noexcept { return counters_; }

 private:
  enum class Transfer : std::uint8_t { none, upload, download, block };

  /// An access to an object, and the form of its response.
  struct Access {
    ObjectAddress object;
    Transfer transfer = Transfer::none;
    std::uint8_t response = 0;             ///< download: first byte of the response
    bool is_wanted = true;                 ///< the client still waits for it
    std::optional<SdoBlockTerms> block{};  ///< set for an upload in blocks
  };

  void serve(const Frame& request, DriveTime now);
  void initiate_upload(const Frame& request, DriveTime now);
  void initiate_download(const Frame& request, DriveTime now);
  void initiate_segments(const Frame& request, const SdoTarget& target, DriveTime now);
  void initiate_block_upload(const Frame& request, DriveTime now);
  void initiate_block_download(const Frame& request, DriveTime now);
  void continue_block(const Frame& request, DriveTime now);
  void conclude_block(DriveTime now);
  void begin_upload(const Access& access, DriveTime now);
  void begin_block(ObjectAddress object, DriveTime now);
  [[nodiscard]] bool is_in_block() const;
  void upload_segment(const Frame& request, DriveTime now);
  void download_segment(const Frame& request, DriveTime now);
  void download(const Access& access, std::span<const std::uint8_t> data, DriveTime now);
  void conclude(const Access& access, const SdoAnswer& answer, DriveTime now);
  void conclude_upload(ObjectAddress object, const SdoAnswer& answer, DriveTime now);
  void conclude_block_upload(const Access& access, const SdoAnswer& answer, DriveTime now);
  void refuse_command(const Frame& request);
  void continue_transfer(DriveTime now);
  void end_transfer();
  /// @return whether `request` is the next segment of the transfer; if not, answers it.
  bool check_segment(const Frame& request, Transfer expected);
  [[nodiscard]] ObjectAddress object_of(const Frame& request) const;
  void send_abort(ObjectAddress object, AbortCode code);
  void send(std::uint8_t command, ObjectAddress object, std::span<const std::uint8_t> data);

  std::uint8_t node_id_;
  NodeHost& host_;
  SdoObjects& objects_;
  SdoCounters counters_;

  Transfer transfer_ = Transfer::none;  ///< segmented or block
  ObjectAddress object_;                ///< of the transfer
  std::string data_;                    ///< of the transfer: to send, or received
  std::size_t position_ = 0;            ///< upload: bytes sent
  std::size_t size_ = 0;                ///< download: bytes expected
  bool toggle_ = false;                 ///< of the next segment
  DriveTime deadline_{};                ///< for the next segment
  std::variant<std::monostate, SdoBlockUpload, SdoBlockDownload> block_;  ///< of Transfer::block

  std::optional<Access> access_;                                         ///< pending
  BoundedQueue<Frame> waiting_{kMostWaiting, WhenFull::refuses_newest};  ///< until the pending
                                                                         ///< access ends
};

}  // namespace vdrive::canopen
