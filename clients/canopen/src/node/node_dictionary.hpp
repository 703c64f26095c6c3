// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/communication_parameters.hpp"
#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/node_settings.hpp"
#include "node/sdo_server.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace vdrive::canopen {

class Emergency;
class HeartbeatConsumer;
class HeartbeatProducer;
class Pdos;
struct NodeObject;

/// The parts of a node that hold communication objects.
struct ObjectParts {
  CommunicationParameters& parameters;
  Pdos& pdos;
  Emergency& emergency;
  HeartbeatProducer& producer;
  HeartbeatConsumer& consumer;
};

/// The object dictionary of a node (CiA 301, 7.4) as node_objects() describes it: forwards each
/// access to the part of the node that holds the object, or to the drive.
///
/// 1020h (verify configuration) holds the value that a configuration tool has written and 1010h:01
/// has saved; it returns to 0 when 1010h:01 saves a changed configuration without a new 1020h (CiA
/// 301, 7.5.2.23).
///
/// An access is checked in this order: index, sub-index, access, length, value. The drive checks
/// the values of its own objects.
class NodeDictionary final : public SdoObjects {
 public:
  /// @param settings its texts are copied
  /// @param parts outlive the dictionary
  /// @param host outlives the dictionary
  /// @param drive outlives the dictionary: the present drive
  NodeDictionary(const NodeSettings& settings, const ObjectParts& parts, NodeHost& host,
                 const DriveView& drive);

  [[nodiscard]] SdoTarget check_download(ObjectAddress object) const override;
  std::optional<SdoAnswer> begin_upload(ObjectAddress object) override;
  std::optional<SdoAnswer> begin_download(ObjectAddress object, std::span<const std::uint8_t> data,
                                          DriveTime now) override;

  /// The answer of the drive to the access with this ticket. When the drive has saved (1010h:01) or
  /// restored (1011h:01) its parameters, the communication parameters follow; those in force when
  /// the request arrived are saved. The answer is hardware_error when NodeHost::store() fails.
  /// @return the answer for SDO; none = no such access is pending.
  std::optional<SdoAnswer> complete(std::uint32_t ticket, const DriveAnswer& answer);

  /// The pending access will not be answered.
  void forget_access() noexcept { access_.reset(); }

  /// The parameters are the saved ones again, so a value of 1020h that was not saved is gone too.
  void forget_date() noexcept { is_dated_ = false; }

  /// @return the value of an object of the node itself; none if it is a text, belongs to the drive,
  ///         or does not exist.
  [[nodiscard]] std::optional<std::int64_t> value(ObjectAddress object) const;

  /// Writes a communication parameter.
  /// @pre CommunicationParameters::has(object)
  /// @return value_too_high or value_too_low outside the limits of the object, otherwise the answer
  ///         of the part that holds it.
  AbortCode write(ObjectAddress object, std::uint32_t value, DriveTime now);

  /// @return the number of calls of write().
  [[nodiscard]] std::uint64_t writes() const noexcept { return writes_; }

 private:
  void begin(ObjectAddress object, std::optional<std::int64_t> value);
  [[nodiscard]] SdoAnswer read_error_field(const NodeObject& object) const;
  [[nodiscard]] SdoAnswer read_own(const NodeObject& object) const;
  [[nodiscard]] std::uint32_t value_of(const NodeObject& object) const;
  [[nodiscard]] std::int64_t as_masters_see(const DriveAccess& access, std::int64_t value) const;
  [[nodiscard]] AbortCode follow_memory(ObjectAddress object);
  void note_written(ObjectAddress object);
  [[nodiscard]] CommunicationParameters::Values parameters_in_force() const;

  std::uint8_t node_id_;
  std::string device_name_;       ///< 1008h
  std::string hardware_version_;  ///< 1009h
  std::string software_version_;  ///< 100Ah
  ObjectParts parts_;
  NodeHost& host_;
  const DriveView& drive_;
  std::uint32_t last_ticket_ = 0;
  std::uint64_t writes_ = 0;
  std::optional<DriveAccess> access_;         ///< pending access to the drive
  bool is_changed_ = false;                   ///< the parameters have changed since the last
                                              ///< 1010h:01
  bool is_dated_ = false;                     ///< 1020h was written since that change
  CommunicationParameters::Values to_store_;  ///< parameters in force when the pending 1010h:01 was
                                              ///< requested
};

}  // namespace vdrive::canopen
