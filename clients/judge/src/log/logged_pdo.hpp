// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/data_sheet_reader.hpp"
#include "node/node_object.hpp"
#include "vdrive/dictionary/object.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::judge {

/// The source of the parameters of a PDO.
enum class PdoOrigin : std::uint8_t {
  profile,  ///< the default mapping of CiA 402
  sheet,    ///< an electronic data sheet
  traffic,  ///< read or written by the master
};

/// An object in a PDO.
struct LoggedEntry {
  ObjectAddress object;
  std::size_t size = 0;  ///< [bytes]
};

/// A PDO of a node, as far as the log shows it (CiA 301, 7.5.2.35 to 7.5.2.38). The node may be of
/// any manufacturer, so mapped objects need not be in our dictionary.
class LoggedPdo {
 public:
  void set_communication(std::uint8_t subindex, std::uint32_t value, PdoOrigin origin);
  void set_mapping(std::uint8_t subindex, std::uint32_t value, PdoOrigin origin);

  /// @return the CAN-ID; nothing if the PDO is not valid or unknown.
  [[nodiscard]] std::optional<std::uint32_t> can_id() const noexcept;

  /// @return the transmission type; nothing if it is known from the profile only.
  [[nodiscard]] std::optional<std::uint8_t> type() const noexcept { return type_; }

  [[nodiscard]] PdoOrigin mapping_origin() const noexcept { return mapping_origin_; }

  /// @return the mapped objects; empty if they are unknown: entries are missing, or map parts of
  ///         bytes.
  [[nodiscard]] std::span<const LoggedEntry> entries() const noexcept { return entries_; }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }  ///< [bytes]

 private:
  static constexpr std::size_t kMostEntries = 64;

  void map();

  std::optional<std::uint32_t> cob_id_;
  std::optional<std::uint8_t> type_;
  PdoOrigin mapping_origin_ = PdoOrigin::profile;
  std::uint8_t count_ = 0;
  std::vector<std::uint32_t> raw_;  ///< entries as stored in the object
  std::vector<LoggedEntry> entries_;
  std::size_t size_ = 0;
};

/// Identifies a PDO of a node.
struct PdoRef {
  std::uint8_t node = 0;
  canopen::PdoDirection direction = canopen::PdoDirection::receive;
  std::uint16_t number = 1;  ///< from 1

  friend bool operator==(const PdoRef&, const PdoRef&) = default;
};

/// The PDOs of one node.
class LoggedPdos {
 public:
  /// Starts with the defaults of CiA 402 and the contents of the data sheet.
  /// @param sheet nullptr = none; must outlive the PDOs
  LoggedPdos(std::uint8_t node, const canopen::DataSheet* sheet);

  /// Resets the PDOs to the state after power-up.
  void reset();

  /// Records a value that the master has read or written.
  /// @return whether it was a PDO parameter
  bool set(ObjectAddress object, std::uint32_t value, PdoOrigin origin = PdoOrigin::traffic);

  [[nodiscard]] const LoggedPdo* find(const PdoRef& ref) const;

  /// @return the CAN-IDs in use, each with its PDO.
  [[nodiscard]] std::vector<std::pair<std::uint32_t, PdoRef>> can_ids() const;

 private:
  using Key = std::pair<canopen::PdoDirection, std::uint16_t>;

  std::uint8_t node_;
  const canopen::DataSheet* sheet_;
  std::map<Key, LoggedPdo> pdos_;
};

}  // namespace vdrive::judge
