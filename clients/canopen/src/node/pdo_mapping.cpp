// SPDX-License-Identifier: Apache-2.0
#include "node/pdo_mapping.hpp"

#include "node/node_object.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>

namespace vdrive::canopen {
namespace {

constexpr std::uint32_t kHighestCount = 0x40;  // 41h to FDh are reserved; FEh, FFh: multiplex PDOs

/// A decoded mapping entry, or why it is refused.
struct Resolved {
  AbortCode refusal = AbortCode::none;
  MappedObject object{};
};

const StatusMember* find_published_member(ObjectAddress address) {
  const auto members = status_members();
  const auto found = std::ranges::find_if(members, [address](const StatusMember& member) {
    return member.is_published && member.address == address;
  });
  return found == members.end() ? nullptr : &*found;
}

Resolved resolve_dummy(ObjectAddress address, PdoDirection direction) {
  if (address.subindex != 0) return {.refusal = AbortCode::object_does_not_exist};
  if (direction != PdoDirection::receive) return {.refusal = AbortCode::cannot_be_mapped_to_pdo};
  return {.object = {.address = address, .type = static_cast<NodeDataType>(address.index)}};
}

Resolved resolve_object(ObjectAddress address, PdoDirection direction) {
  const NodeObject* const object = find_node_object(address);
  // CiA 301 has one code for a mapped object whose index or sub-index is missing.
  if (object == nullptr) return {.refusal = AbortCode::object_does_not_exist};
  if (!allows(object->mapping, direction)) return {.refusal = AbortCode::cannot_be_mapped_to_pdo};
  Resolved resolved{.object = {.address = address, .type = object->data_type}};
  if (direction == PdoDirection::transmit) resolved.object.member = find_published_member(address);
  return resolved;
}

Resolved resolve(std::uint32_t entry, PdoDirection direction) {
  const ObjectAddress address{.index = static_cast<std::uint16_t>(entry >> 16U),
                              .subindex = static_cast<std::uint8_t>((entry >> 8U) & 0xFFU)};
  const bool is_dummy = address.index >= kFirstDummy && address.index <= kLastDummy;
  Resolved resolved =
      is_dummy ? resolve_dummy(address, direction) : resolve_object(address, direction);
  const std::uint32_t bits = entry & 0xFFU;
  if (resolved.refusal == AbortCode::none && bits != size_of(resolved.object.type) * 8U) {
    resolved.refusal = AbortCode::cannot_be_mapped_to_pdo;
  }
  return resolved;
}

}  // namespace

MappingRecord::MappingRecord(std::uint16_t index, PdoDirection direction)
    : index_(index), direction_(direction) {
  reset();
}

void MappingRecord::reset() {
  for (std::size_t entry = 0; entry < kMostEntries; ++entry) {
    entries_[entry] = initial_value({index_, static_cast<std::uint8_t>(entry + 1)});
  }
  const AbortCode refusal = write_count(initial_value({index_, 0}));
  ensure(refusal == AbortCode::none, "the default of a mapping can be mapped");
}

std::uint32_t MappingRecord::read(std::uint8_t subindex) const noexcept {
  if (subindex == 0) return count_;
  return subindex <= kMostEntries ? entries_[subindex - 1U] : 0U;
}

AbortCode MappingRecord::write(std::uint8_t subindex, std::uint32_t value, bool is_pdo_valid) {
  if (subindex > kMostEntries) return AbortCode::subindex_does_not_exist;
  if (is_pdo_valid) return AbortCode::unsupported_access;
  return subindex == 0 ? write_count(value) : write_entry(subindex - 1U, value);
}

AbortCode MappingRecord::write_count(std::uint32_t count) {
  if (count > kHighestCount) return AbortCode::value_range_exceeded;
  if (count > kMostEntries) return AbortCode::pdo_length_exceeded;
  std::array<MappedObject, kMostEntries> objects{};
  std::size_t size = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Resolved resolved = resolve(entries_[i], direction_);
    if (resolved.refusal != AbortCode::none) return resolved.refusal;
    objects[i] = resolved.object;
    size += size_of(resolved.object.type);
  }
  if (size > kMostData) return AbortCode::pdo_length_exceeded;
  objects_ = objects;
  count_ = static_cast<std::uint8_t>(count);
  size_ = static_cast<std::uint8_t>(size);
  return AbortCode::none;
}

AbortCode MappingRecord::write_entry(std::size_t number, std::uint32_t entry) {
  if (count_ != 0) return AbortCode::unsupported_access;
  // 0 is the default of an unused entry; a master that restores a configuration writes it back.
  const AbortCode refusal = entry == 0 ? AbortCode::none : resolve(entry, direction_).refusal;
  if (refusal == AbortCode::none) entries_[number] = entry;
  return refusal;
}

}  // namespace vdrive::canopen
