// SPDX-License-Identifier: Apache-2.0
#include "log/logged_pdo.hpp"

#include "node/cob_id.hpp"

#include <algorithm>

namespace vdrive::judge {
namespace {

using canopen::PdoDirection;

constexpr std::uint16_t kReceiveCommunication = 0x1400;
constexpr std::uint16_t kReceiveMapping = 0x1600;
constexpr std::uint16_t kTransmitCommunication = 0x1800;
constexpr std::uint16_t kTransmitMapping = 0x1A00;
constexpr std::uint16_t kPdoObjects = 0x200;  // for each of the four kinds
constexpr std::uint16_t kFirstPdoObject = kReceiveCommunication;
constexpr std::uint16_t kLastPdoObject = kTransmitMapping + kPdoObjects - 1;
constexpr std::size_t kBitsOfAByte = 8;

/// The meaning of an index from 1400h to 1BFFh.
struct PdoIndex {
  PdoDirection direction;
  bool is_mapping;
  std::uint16_t number;  ///< from 1
};

PdoIndex pdo_index(std::uint16_t index) {
  const bool is_transmit = index >= kTransmitCommunication;
  const int within = index - (is_transmit ? kTransmitCommunication : kReceiveCommunication);
  return {is_transmit ? PdoDirection::transmit : PdoDirection::receive, within >= kPdoObjects,
          static_cast<std::uint16_t>(within % kPdoObjects + 1)};
}

}  // namespace

void LoggedPdo::set_communication(std::uint8_t subindex, std::uint32_t value, PdoOrigin origin) {
  if (subindex == 1) cob_id_ = value;
  // The default type of the profile is not used: the manufacturer may not follow it.
  if (subindex == 2 && origin != PdoOrigin::profile) type_ = static_cast<std::uint8_t>(value);
}

void LoggedPdo::set_mapping(std::uint8_t subindex, std::uint32_t value, PdoOrigin origin) {
  mapping_origin_ = origin;
  if (subindex == 0) {
    count_ = static_cast<std::uint8_t>(std::min<std::uint32_t>(value, kMostEntries));
  } else if (subindex <= kMostEntries) {
    if (raw_.size() < subindex) raw_.resize(subindex);
    raw_[subindex - 1U] = value;
  }
  map();
}

void LoggedPdo::map() {
  entries_.clear();
  size_ = 0;
  std::vector<LoggedEntry> entries;
  std::size_t size = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const std::uint32_t raw = i < raw_.size() ? raw_[i] : 0;
    const std::size_t bits = raw & 0xFFU;
    if (bits == 0 || bits % kBitsOfAByte != 0) return;
    const LoggedEntry entry{.object = {.index = static_cast<std::uint16_t>(raw >> 16U),
                                       .subindex = static_cast<std::uint8_t>(raw >> 8U)},
                            .size = bits / kBitsOfAByte};
    size += entry.size;
    if (size > canopen::kMostData) return;
    entries.push_back(entry);
  }
  entries_ = std::move(entries);
  size_ = size;
}

std::optional<std::uint32_t> LoggedPdo::can_id() const noexcept {
  const bool is_valid = cob_id_ && (*cob_id_ & canopen::kCobIdNotValid) == 0 &&
                        (*cob_id_ & canopen::kCobIdExtendedBits) == 0;
  return is_valid ? std::optional(canopen::can_id_of(*cob_id_)) : std::nullopt;
}

LoggedPdos::LoggedPdos(std::uint8_t node, const canopen::DataSheet* sheet)
    : node_(node), sheet_(sheet) {
  reset();
}

void LoggedPdos::reset() {
  pdos_.clear();
  for (const canopen::NodeObject& object : canopen::node_objects()) {
    if (object.data_type == canopen::NodeDataType::visible_string) continue;
    const auto value = static_cast<std::uint32_t>(canopen::default_of(object, node_));
    static_cast<void>(set(object.address, value, PdoOrigin::profile));
  }
  if (sheet_ == nullptr) return;
  // A node that lacks a PDO of the profile has no section for it.
  std::erase_if(pdos_, [this](const auto& entry) {
    const auto& [direction, number] = entry.first;
    const auto index = static_cast<std::uint16_t>(
        (direction == PdoDirection::transmit ? kTransmitCommunication : kReceiveCommunication) +
        number - 1);
    return !sheet_->contains({index, 1});
  });
  for (const auto& [address, object] : *sheet_) {
    if (!object.value) continue;
    const std::uint32_t node_id = object.has_node_id ? node_ : 0U;
    static_cast<void>(
        set(address, static_cast<std::uint32_t>(*object.value) + node_id, PdoOrigin::sheet));
  }
}

bool LoggedPdos::set(ObjectAddress object, std::uint32_t value, PdoOrigin origin) {
  if (object.index < kFirstPdoObject || object.index > kLastPdoObject) return false;
  const PdoIndex index = pdo_index(object.index);
  LoggedPdo& pdo = pdos_[{index.direction, index.number}];
  if (index.is_mapping) {
    pdo.set_mapping(object.subindex, value, origin);
  } else {
    pdo.set_communication(object.subindex, value, origin);
  }
  return true;
}

const LoggedPdo* LoggedPdos::find(const PdoRef& ref) const {
  const auto pdo = pdos_.find({ref.direction, ref.number});
  return pdo == pdos_.end() ? nullptr : &pdo->second;
}

std::vector<std::pair<std::uint32_t, PdoRef>> LoggedPdos::can_ids() const {
  std::vector<std::pair<std::uint32_t, PdoRef>> ids;
  for (const auto& [key, pdo] : pdos_) {
    const auto id = pdo.can_id();
    if (id) ids.push_back({*id, {.node = node_, .direction = key.first, .number = key.second}});
  }
  return ids;
}

}  // namespace vdrive::judge
