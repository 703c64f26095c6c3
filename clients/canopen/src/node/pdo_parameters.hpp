// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/cob_id.hpp"
#include "node/frame.hpp"
#include "node/node_object.hpp"
#include "node/pdo_mapping.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>

namespace vdrive::canopen {

// Transmission types (CiA 301, 7.5.2.35 and 7.5.2.37). The values in between are reserved.
inline constexpr std::uint8_t kAcyclicSynchronous = 0;   ///< at the SYNC after a change
inline constexpr std::uint8_t kLastSynchronous = 240;    ///< 1 to 240: at every n-th SYNC
inline constexpr std::uint8_t kRemoteSynchronous = 252;  ///< TPDO: on request, sampled at SYNC
inline constexpr std::uint8_t kRemoteEventDriven = 253;  ///< TPDO: on request, sampled at the
                                                         ///< request
inline constexpr std::uint8_t kFirstEventDriven = 254;   ///< 254 and 255: immediately

/// Identifies a PDO of a node.
struct PdoPlace {
  std::uint8_t number = 1;   ///< 1 to 4
  std::uint8_t node_id = 1;  ///< 1 to 127
};

/// The values in force of a PDO's two records: communication parameter (CiA 301, 7.5.2.35: 1400h..
/// for an RPDO; 7.5.2.37: 1800h.. for a TPDO) and mapping.
///
/// A valid PDO always has an unrestricted CAN-ID and at least one mapped object.
class PdoParameters {
 public:
  /// Starts with the defaults of the dictionary.
  PdoParameters(PdoDirection direction, PdoPlace place);

  /// Sets all objects back to their defaults.
  void reset();

  /// @pre `object` belongs to one of the two records
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const;

  /// @pre `object` belongs to one of the two records
  /// @return for the mapping: as MappingRecord::write(); for the communication parameter:
  ///         write_of_read_only_object for :00;
  ///         value_range_exceeded for a COB-ID with any of bits 11 to 29 set; for one that
  ///         makes the PDO valid and has a restricted CAN-ID, no mapped objects, or a CAN-ID other
  ///         than that of the already valid PDO; for a reserved transmission type; for 252 and 253
  ///         of an RPDO; for a change of inhibit time or SYNC start value while the PDO is valid;
  ///         for a SYNC start value above 240, and a time above 65535;
  ///         subindex_does_not_exist for a sub-index that the record does not have;
  ///         otherwise none: the value is in force.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  [[nodiscard]] bool is_valid() const noexcept { return (cob_id_ & kCobIdNotValid) == 0; }

  [[nodiscard]] std::uint32_t can_id() const noexcept { return can_id_of(cob_id_); }

  [[nodiscard]] bool allows_remote() const noexcept { return (cob_id_ & kCobIdNoRemote) == 0; }

  [[nodiscard]] std::uint8_t type() const noexcept { return type_; }

  [[nodiscard]] DriveTime inhibit_time() const noexcept;  ///< 0 = none
  [[nodiscard]] DriveTime event_time() const noexcept;    ///< 0 = none

  [[nodiscard]] std::uint8_t sync_start() const noexcept { return sync_start_; }  ///< 0 = none

  [[nodiscard]] const MappingRecord& mapping() const noexcept { return mapping_; }

 private:
  [[nodiscard]] bool is_mapping(ObjectAddress object) const noexcept;
  [[nodiscard]] std::uint32_t read_communication(std::uint8_t subindex) const;
  AbortCode write_communication(std::uint8_t subindex, std::uint32_t value);
  AbortCode write_cob_id(std::uint32_t value);
  AbortCode write_type(std::uint32_t value);
  AbortCode write_inhibit_time(std::uint32_t value);
  AbortCode write_event_timer(std::uint32_t value);
  AbortCode write_sync_start(std::uint32_t value);

  PdoDirection direction_;
  std::uint16_t index_;  ///< of the communication parameter
  std::uint8_t node_id_;
  MappingRecord mapping_;
  std::uint32_t cob_id_ = kCobIdNotValid;
  std::uint16_t inhibit_ = 0;      ///< [100 us]
  std::uint16_t event_timer_ = 0;  ///< [ms]
  std::uint8_t type_ = 0;
  std::uint8_t sync_start_ = 0;
};

}  // namespace vdrive::canopen
