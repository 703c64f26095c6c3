// SPDX-License-Identifier: Apache-2.0
#include "node/communication_parameters.hpp"

#include "node/cob_id.hpp"
#include "node/node_object.hpp"

#include <array>
#include <set>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr std::uint16_t kFirstPdoIndex = 0x1400;
constexpr std::uint16_t kLastPdoIndex = 0x1BFF;

/// Offset of a PDO's mapping from its communication parameter: 1400h to 1600h, 1800h to 1A00h.
constexpr std::uint16_t kToMapping = 0x0200;

/// 1019h comes first: it is refused while 1006h is not 0.
constexpr std::array<std::uint16_t, 2> kFirstRestored{0x1019, 0x1005};

constexpr std::uint16_t kEmergencyCobIdIndex = 0x1014;

bool is_parameter(const NodeObject& object) {
  return object.owner == ObjectOwner::node && object.access == NodeAccess::read_write;
}

bool is_pdo(std::uint16_t index) {
  return index >= kFirstPdoIndex && index <= kLastPdoIndex;
}

/// @param index of the communication parameter or the mapping of a PDO
/// @return the index of its communication parameter
std::uint16_t parameters_of(std::uint16_t index) {
  return static_cast<std::uint16_t>(index & ~unsigned{kToMapping});
}

}  // namespace

CommunicationParameters::CommunicationParameters(std::uint8_t node_id, Values stored)
    : node_id_(node_id), stored_(std::move(stored)) {
  std::erase_if(stored_, [this](const Values::value_type& saved) {
    return !has(saved.first) || saved.second == initial_value(saved.first, node_id_);
  });
}

bool CommunicationParameters::has(ObjectAddress object) {
  const NodeObject* const found = find_node_object(object);
  return found != nullptr && is_parameter(*found);
}

CommunicationParameters::Values CommunicationParameters::to_store(const Read& in_force) const {
  Values values;
  for (const NodeObject& object : node_objects()) {
    if (!is_parameter(object)) continue;
    const std::uint32_t value = in_force(object.address);
    if (value != initial_value(object.address, node_id_)) values.emplace(object.address, value);
  }
  return values;
}

void CommunicationParameters::restore(const Write& write) const {
  std::set<std::uint16_t> pdos;
  std::set<std::uint16_t> others;
  for (const auto& [object, value] : stored_) {
    if (is_pdo(object.index)) {
      pdos.insert(parameters_of(object.index));
    } else {
      others.insert(object.index);
    }
  }
  for (const std::uint16_t index : kFirstRestored) {
    if (others.erase(index) != 0) restore_index(index, write);
  }
  for (const std::uint16_t index : others) restore_index(index, write);
  for (const std::uint16_t index : pdos) restore_pdo(index, write);
}

void CommunicationParameters::restore_index(std::uint16_t index, const Write& write) const {
  if (index == kEmergencyCobIdIndex) return restore_cob_id({index, 0}, write);
  for (auto at = stored_.lower_bound({index, 0}); at != stored_.end() && at->first.index == index;
       ++at) {
    static_cast<void>(write(at->first, at->second));
  }
}

/// A mapping and most parameters can change only while the PDO is not valid, so it becomes valid
/// last.
void CommunicationParameters::restore_pdo(std::uint16_t parameters, const Write& write) const {
  const ObjectAddress cob_id{parameters, 1};
  static_cast<void>(write(cob_id, initial_value(cob_id, node_id_) | kCobIdNotValid));
  restore_mapping(static_cast<std::uint16_t>(parameters + kToMapping), write);
  for (auto at = stored_.upper_bound(cob_id); at != stored_.end() && at->first.index == parameters;
       ++at) {
    static_cast<void>(write(at->first, at->second));
  }
  restore_cob_id(cob_id, write);
}

/// Entries can change only while the count is 0.
void CommunicationParameters::restore_mapping(std::uint16_t index, const Write& write) const {
  const ObjectAddress count{index, 0};
  auto at = stored_.lower_bound(count);
  if (at == stored_.end() || at->first.index != index) return;
  static_cast<void>(write(count, 0));
  for (; at != stored_.end() && at->first.index == index; ++at) {
    if (at->first != count) static_cast<void>(write(at->first, at->second));
  }
  static_cast<void>(write(count, restored(count)));
}

/// The CAN-ID can change only while the COB-ID is not valid. If the stored value is refused, the
/// default is written so that the COB-ID does not stay invalid.
void CommunicationParameters::restore_cob_id(ObjectAddress object, const Write& write) const {
  static_cast<void>(write(object, initial_value(object, node_id_) | kCobIdNotValid));
  if (write(object, restored(object)) != AbortCode::none) {
    static_cast<void>(write(object, initial_value(object, node_id_)));
  }
}

std::uint32_t CommunicationParameters::value(ObjectAddress object) const {
  const auto found = in_force_.find(object);
  return found == in_force_.end() ? initial_value(object, node_id_) : found->second;
}

void CommunicationParameters::set_value(ObjectAddress object, std::uint32_t value) {
  in_force_.insert_or_assign(object, value);
}

std::uint32_t CommunicationParameters::restored(ObjectAddress object) const {
  const auto found = stored_.find(object);
  return found == stored_.end() ? initial_value(object, node_id_) : found->second;
}

}  // namespace vdrive::canopen
