// SPDX-License-Identifier: Apache-2.0
#include "node/node_dictionary.hpp"

#include "node/emergency.hpp"
#include "node/frame.hpp"
#include "node/heartbeat.hpp"
#include "node/node_object.hpp"
#include "node/pdos.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <array>
#include <cstddef>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr ObjectAddress kErrorRegister{0x1001, 0};
constexpr std::uint16_t kErrorField = 0x1003;
constexpr ObjectAddress kStoreAll{0x1010, 1};
constexpr ObjectAddress kRestoreAll{0x1011, 1};
constexpr std::uint16_t kVerifyIndex = 0x1020;
constexpr std::array kDateAndTime{ObjectAddress{kVerifyIndex, 1}, ObjectAddress{kVerifyIndex, 2}};
constexpr ObjectAddress kStatusword{0x6041, 0};

constexpr std::uint16_t kDeviceName = 0x1008;
constexpr std::uint16_t kHardwareVersion = 0x1009;
constexpr std::uint16_t kSoftwareVersion = 0x100A;

bool is_writable(const NodeObject& object) {
  return object.access == NodeAccess::read_write || object.access == NodeAccess::write_only;
}

/// @param size 1 to 4
std::string bytes_of_number(std::int64_t number, std::uint8_t size) {
  std::array<std::uint8_t, 4> bytes{};
  put_little_endian(static_cast<std::uint64_t>(number), bytes);
  return {bytes.begin(), bytes.begin() + size};
}

}  // namespace

NodeDictionary::NodeDictionary(const NodeSettings& settings, const ObjectParts& parts,
                               NodeHost& host, const DriveView& drive)
    : node_id_(settings.node_id),
      device_name_(settings.device_name),
      hardware_version_(settings.hardware_version),
      software_version_(settings.software_version),
      parts_(parts),
      host_(host),
      drive_(drive) {}

SdoTarget NodeDictionary::check_download(ObjectAddress object) const {
  const NodeObject* const found = find_node_object(object);
  if (found == nullptr) return {.abort = check_node_address(object)};
  if (!is_writable(*found)) return {.abort = AbortCode::write_of_read_only_object};
  return {.size = size_of(found->data_type)};
}

std::optional<SdoAnswer> NodeDictionary::begin_upload(ObjectAddress object) {
  const NodeObject* const found = find_node_object(object);
  if (found == nullptr) return SdoAnswer{.abort = check_node_address(object)};
  if (found->access == NodeAccess::write_only) {
    return SdoAnswer{.abort = AbortCode::read_of_write_only_object};
  }
  if (object.index == kErrorField) return read_error_field(*found);
  if (found->owner == ObjectOwner::node) return read_own(*found);
  begin(object, std::nullopt);
  return std::nullopt;
}

std::optional<SdoAnswer> NodeDictionary::begin_download(ObjectAddress object,
                                                        std::span<const std::uint8_t> data,
                                                        DriveTime now) {
  const NodeObject* const found = find_node_object(object);
  ensure(found != nullptr && data.size() == size_of(found->data_type),
         "a download was checked before it begins");
  const std::int64_t number = number_of(found->data_type, data);
  if (found->owner == ObjectOwner::node) {
    const AbortCode abort = write(object, static_cast<std::uint32_t>(number), now);
    if (abort == AbortCode::none) note_written(object);
    return SdoAnswer{.abort = abort};
  }
  begin(object, number);
  return std::nullopt;
}

void NodeDictionary::begin(ObjectAddress object, std::optional<std::int64_t> value) {
  ++last_ticket_;
  // Taken now, because an NMT reset before the answer would change the values.
  if (object == kStoreAll && value) {
    to_store_ = parameters_in_force();
    if (is_changed_ && !is_dated_) {
      for (const ObjectAddress part : kDateAndTime) to_store_.erase(part);
    }
  }
  access_ = DriveAccess{.ticket = last_ticket_, .object = object, .value = value};
  host_.begin_access(*access_);
}

std::optional<SdoAnswer> NodeDictionary::complete(std::uint32_t ticket, const DriveAnswer& answer) {
  if (!access_ || access_->ticket != ticket) return std::nullopt;
  const DriveAccess access = *std::exchange(access_, std::nullopt);
  if (answer.abort != AbortCode::none) return SdoAnswer{.abort = answer.abort};
  if (access.value) return SdoAnswer{.abort = follow_memory(access.object)};
  const NodeObject* const found = find_node_object(access.object);
  ensure(found != nullptr, "an access has an object");
  return SdoAnswer{
      .bytes = bytes_of_number(as_masters_see(access, answer.value), size_of(found->data_type))};
}

std::int64_t NodeDictionary::as_masters_see(const DriveAccess& access, std::int64_t value) const {
  if (access.object == kStatusword && !drive_.is_owned) {
    return value & ~std::int64_t{Statusword::kRemote};
  }
  return access.object == kErrorRegister ? value | parts_.emergency.error_register() : value;
}

/// Reads the node's list of errors: the drive's own lacks the communication errors.
SdoAnswer NodeDictionary::read_error_field(const NodeObject& object) const {
  const auto& history = parts_.emergency.history();
  const std::size_t entry = object.address.subindex;
  if (entry > history.size()) return {.abort = AbortCode::no_data_available};
  const std::size_t value = entry == 0 ? history.size() : history[entry - 1];
  return {.bytes = bytes_of_number(static_cast<std::int64_t>(value), size_of(object.data_type))};
}

/// @param object object of the drive that was written
AbortCode NodeDictionary::follow_memory(ObjectAddress object) {
  if (object.index == kErrorField) parts_.emergency.clear_history();
  if (object != kStoreAll && object != kRestoreAll) {
    note_written(object);
    return AbortCode::none;
  }
  CommunicationParameters::Values parameters;  // empty: all have their defaults
  if (object == kStoreAll) parameters = std::exchange(to_store_, {});
  if (!host_.store(parameters)) return AbortCode::hardware_error;
  if (object == kStoreAll) {
    for (const ObjectAddress part : kDateAndTime) {
      const auto saved = parameters.find(part);
      parts_.parameters.set_value(part, saved == parameters.end() ? 0 : saved->second);
    }
  }
  is_changed_ = false;
  is_dated_ = false;
  parts_.parameters.set_stored(std::move(parameters));
  return AbortCode::none;
}

/// A master has written an object.
void NodeDictionary::note_written(ObjectAddress object) {
  if (object.index == kVerifyIndex) {
    is_dated_ = true;
    return;
  }
  const auto row = find_object(object);
  is_changed_ = is_changed_ || CommunicationParameters::has(object) ||
                (row && vdrive::describe(*row).storage == Storage::flash);
}

CommunicationParameters::Values NodeDictionary::parameters_in_force() const {
  return parts_.parameters.to_store([this](ObjectAddress parameter) {
    return static_cast<std::uint32_t>(value(parameter).value_or(0));
  });
}

SdoAnswer NodeDictionary::read_own(const NodeObject& object) const {
  switch (object.address.index) {
    case kDeviceName:
      return {.bytes = device_name_, .is_text = true};
    case kHardwareVersion:
      return {.bytes = hardware_version_, .is_text = true};
    case kSoftwareVersion:
      return {.bytes = software_version_, .is_text = true};
    default:
      return {.bytes = bytes_of_number(value_of(object), size_of(object.data_type))};
  }
}

std::optional<std::int64_t> NodeDictionary::value(ObjectAddress object) const {
  const NodeObject* const found = find_node_object(object);
  const bool has_number = found != nullptr && found->owner == ObjectOwner::node &&
                          found->data_type != NodeDataType::visible_string;
  return has_number ? std::optional(std::int64_t{value_of(*found)}) : std::nullopt;
}

/// @param object a numeric object of the node itself
std::uint32_t NodeDictionary::value_of(const NodeObject& object) const {
  if (Pdos::has(object.address)) return parts_.pdos.read(object.address);
  if (!is_writable(object)) return static_cast<std::uint32_t>(default_of(object, node_id_));
  switch (object.address.index) {
    case 0x1014:
      return parts_.emergency.cob_id();
    case 0x1015:
      return parts_.emergency.inhibit_time();
    case 0x1016:
      return parts_.consumer.entry(object.address.subindex);
    case 0x1017:
      return parts_.producer.time();
    default:
      return parts_.parameters.value(object.address);
  }
}

AbortCode NodeDictionary::write(ObjectAddress object, std::uint32_t value, DriveTime now) {
  ++writes_;
  if (Pdos::has(object)) return parts_.pdos.write(object, value);
  const NodeObject* const found = find_node_object(object);
  ensure(found != nullptr, "a communication parameter exists");
  if (value > found->upper_limit) return AbortCode::value_too_high;
  if (value < found->lower_limit) return AbortCode::value_too_low;
  switch (object.index) {
    case 0x1014:
      return parts_.emergency.set_cob_id(value);
    case 0x1015:
      parts_.emergency.set_inhibit_time(static_cast<std::uint16_t>(value));
      return AbortCode::none;
    case 0x1016:
      return parts_.consumer.set_entry(object.subindex, value);
    case 0x1017:
      parts_.producer.set_time(static_cast<std::uint16_t>(value), now);
      return AbortCode::none;
    default:
      parts_.parameters.set_value(object, value);
      return AbortCode::none;
  }
}

}  // namespace vdrive::canopen
