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

/// Indices of the data types that an RPDO may map as a dummy: bytes that the node skips (CiA 301,
/// 7.5.2.36).
inline constexpr std::uint16_t kFirstDummy = 0x0002;
inline constexpr std::uint16_t kLastDummy = 0x0007;

/// An object in a PDO. It takes size_of(type) bytes, least significant first.
struct MappedObject {
  ObjectAddress address;
  NodeDataType type = NodeDataType::unsigned8;
  const StatusMember* member = nullptr;  ///< TPDO: where the value comes from; nullptr = must be
                                         ///< read

  [[nodiscard]] bool is_dummy() const noexcept { return address.index <= kLastDummy; }
};

/// A PDO mapping record: the objects that a PDO carries (CiA 301, 7.5.2.36 and 7.5.2.38: 1600h..
/// for RPDOs, 1A00h.. for TPDOs). An entry holds the index (bits 16 to 31), the sub-index (bits 8
/// to 15) and the length [bits] (bits 0 to 7) of an object; 0 = not used.
///
/// The objects within its count always exist, can be mapped, have the length of their type, and
/// together fit into a frame.
class MappingRecord {
 public:
  /// Each entry takes at least one byte.
  static constexpr std::size_t kMostEntries = kMostData;

  /// Starts with the defaults of the dictionary.
  /// @param direction of the PDO that has this record
  MappingRecord(std::uint16_t index, PdoDirection direction);

  /// Sets all entries back to their defaults.
  void reset();

  /// @param subindex 0 to kMostEntries; higher ones read 0
  [[nodiscard]] std::uint32_t read(std::uint8_t subindex) const noexcept;

  /// @param is_pdo_valid bit 31 of the COB-ID of the PDO is 0
  /// @return subindex_does_not_exist above kMostEntries;
  ///         unsupported_access while the PDO is valid, and for an entry also while the count is
  ///         not 0;
  ///         object_does_not_exist for an entry or count that refers to a missing object or
  ///         sub-index, and for a count that includes an unused entry;
  ///         cannot_be_mapped_to_pdo for an object that PDOs of this direction may not carry, or
  ///         with a length other than that of its type;
  ///         pdo_length_exceeded for a count whose objects exceed 8 bytes, or above kMostEntries;
  ///         value_range_exceeded for an invalid count (above 40h; multiplex PDOs are not
  ///         supported);
  ///         otherwise none: the value is in force.
  AbortCode write(std::uint8_t subindex, std::uint32_t value, bool is_pdo_valid);

  /// The objects of a frame, in order. The span is valid until the next write or reset.
  [[nodiscard]] std::span<const MappedObject> objects() const noexcept {
    return {objects_.data(), count_};
  }

  /// Size of a frame's data, 0 to kMostData [bytes].
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
