// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_object.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::canopen {

/// Indices of the data types that an RPDO may have as a dummy: bytes that the node skips
/// (CiA 301, 7.5.2.36).
inline constexpr std::uint16_t kFirstDummy = 0x0002;
inline constexpr std::uint16_t kLastDummy = 0x0007;

/// An object in a PDO. It takes size_of(type) bytes, the least one first.
struct MappedObject {
  ObjectAddress address;
  NodeDataType type = NodeDataType::unsigned8;
  const StatusMember* member = nullptr;  ///< of a TPDO: has its value; nullptr = it is read

  [[nodiscard]] bool is_dummy() const noexcept { return address.index <= kLastDummy; }
};

/// A PDO mapping record: which objects a PDO carries (CiA 301, 7.5.2.36 and 7.5.2.38: 1600h.. of
/// RPDOs, 1A00h.. of TPDOs). An entry is the index (bits 16 to 31), the sub-index (bits 8 to 15)
/// and the length [bits] (bits 0 to 7) of an object; 0 = not used.
///
/// Its objects, as many as its count, always exist, can be mapped, have the length of their type,
/// and fit into a frame together.
class MappingRecord {
 public:
  /// An entry has a byte at least.
  static constexpr std::size_t kMostEntries = kMostData;

  /// With the defaults of the dictionary.
  /// @param direction whether a TPDO or an RPDO has it
  MappingRecord(std::uint16_t index, PdoDirection direction);

  /// All entries have their defaults again.
  void reset();

  /// @param subindex 0 to kMostEntries; above, 0 is read
  [[nodiscard]] std::uint32_t read(std::uint8_t subindex) const noexcept;

  /// @param is_pdo_valid bit 31 of the COB-ID of the PDO is 0
  /// @return subindex_does_not_exist above kMostEntries;
  ///         unsupported_access while the PDO is valid; for an entry also while the count is not 0;
  ///         object_does_not_exist, for an entry or the count, when an object or its sub-index does
  ///         not exist, and for a count over an entry that is not used;
  ///         cannot_be_mapped_to_pdo for an object that PDOs of this direction cannot have, or in
  ///         another length than that of its type;
  ///         pdo_length_exceeded for a count whose objects have more than 8 bytes, or above
  ///         kMostEntries;
  ///         value_range_exceeded for a count that is none (above 40h; multiplex PDOs are not
  ///         there);
  ///         else none: it is in force.
  AbortCode write(std::uint8_t subindex, std::uint32_t value, bool is_pdo_valid);

  /// What a frame carries, in this order. The span ends with the next write or reset.
  [[nodiscard]] std::span<const MappedObject> objects() const noexcept {
    return {objects_.data(), count_};
  }

  /// Data of a frame, 0 to kMostData [bytes].
  [[nodiscard]] std::uint8_t size() const noexcept { return size_; }

 private:
  AbortCode write_count(std::uint32_t count);
  AbortCode write_entry(std::size_t number, std::uint32_t entry);

  std::uint16_t index_;
  PdoDirection direction_;
  std::array<std::uint32_t, kMostEntries> entries_{};
  std::array<MappedObject, kMostEntries> objects_{};
  std::uint8_t count_ = 0;
  std::uint8_t size_ = 0;
};

}  // namespace vdrive::canopen
