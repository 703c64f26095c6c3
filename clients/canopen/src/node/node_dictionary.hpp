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

/// The parts of a node that have communication objects.
struct ObjectParts {
  CommunicationParameters& parameters;
  Pdos& pdos;
  Emergency& emergency;
  HeartbeatProducer& producer;
  HeartbeatConsumer& consumer;
};

/// The object dictionary of a node (CiA 301, 7.4) as node_objects() describes it: leads each access
/// to the part of the node that has the object, or to the drive.
///
/// 1020h (verify configuration) is what a configuration tool has written there and 1010h:01 saved;
/// it is 0 again when 1010h:01 saves another configuration without it (CiA 301, 7.5.2.23).
///
/// An access is judged in this order: index, sub-index, access, length, value. The value of an
/// object of the drive is judged by the drive.
class NodeDictionary final : public SdoObjects {
 public:
  /// @param settings its texts are copied
  /// @param parts outlive the dictionary
  /// @param host likewise
  /// @param drive likewise: the drive as it is now
  NodeDictionary(const NodeSettings& settings, const ObjectParts& parts, NodeHost& host,
                 const DriveView& drive);

  [[nodiscard]] SdoTarget check_download(ObjectAddress object) const override;
  std::optional<SdoAnswer> begin_upload(ObjectAddress object) override;
  std::optional<SdoAnswer> begin_download(ObjectAddress object, std::span<const std::uint8_t> data,
                                          DriveTime now) override;

  /// The answer of the drive to the access with this ticket. Where it has saved (1010h:01) or
  /// restored (1011h:01) its parameters the communication parameters follow: those that were in
  /// force at the request are saved. The answer is hardware_error where NodeHost::store() cannot
  /// keep them.
  /// @return the answer for SDO; none = no such access is under way.
  std::optional<SdoAnswer> complete(std::uint32_t ticket, const DriveAnswer& answer);

  /// The access that is under way will not be answered.
  void forget_access() noexcept { access_.reset(); }

  /// The parameters are those that were saved: a date in 1020h that was not saved is gone, too.
  void forget_date() noexcept { is_dated_ = false; }

  /// @return the value of an object of the node itself; none when it has a text, is the drive's, or
  ///         does not exist.
  [[nodiscard]] std::optional<std::int64_t> value(ObjectAddress object) const;

  /// Writes a communication parameter.
  /// @pre CommunicationParameters::has(object)
  /// @return value_too_high or value_too_low outside the limits of the object, else what the part
  ///         that has it says.
  AbortCode write(ObjectAddress object, std::uint32_t value, DriveTime now);

  /// @return calls of write().
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
  std::optional<DriveAccess> access_;         ///< of the drive, under way
  bool is_changed_ = false;                   ///< what 1010h:01 saves, since it has
  bool is_dated_ = false;                     ///< 1020h was written since
  CommunicationParameters::Values to_store_;  ///< at the request of 1010h:01 that is under way
};

}  // namespace vdrive::canopen
