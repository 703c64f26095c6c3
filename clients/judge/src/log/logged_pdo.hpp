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

/// Where the parameters of a PDO were learnt.
enum class PdoOrigin : std::uint8_t {
  profile,  ///< the default mapping of CiA 402
  sheet,    ///< an electronic data sheet
  traffic,  ///< the master has read or written it
};

/// An object in a PDO.
struct LoggedEntry {
  ObjectAddress object;
  std::size_t size = 0;  ///< [bytes]
};

/// A PDO of a node, as far as the log shows it (CiA 301, 7.5.2.35 to 7.5.2.38). Of any maker's
/// node: what it maps need not be in our dictionary.
class LoggedPdo {
 public:
  void set_communication(std::uint8_t subindex, std::uint32_t value, PdoOrigin origin);
  void set_mapping(std::uint8_t subindex, std::uint32_t value, PdoOrigin origin);

  /// @return the CAN-ID, or nothing where the PDO is not valid or not known.
  [[nodiscard]] std::optional<std::uint32_t> can_id() const noexcept;

  /// @return the transmission type; nothing where only the profile has one.
  [[nodiscard]] std::optional<std::uint8_t> type() const noexcept { return type_; }

  [[nodiscard]] PdoOrigin mapping_origin() const noexcept { return mapping_origin_; }

  /// @return what it carries; empty where that is not known: entries are missing, or take parts of
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
  std::vector<std::uint32_t> raw_;  ///< entries as the object has them
  std::vector<LoggedEntry> entries_;
  std::size_t size_ = 0;
};

/// Which PDO of which node.
struct PdoRef {
  std::uint8_t node = 0;
  canopen::PdoDirection direction = canopen::PdoDirection::receive;
  std::uint16_t number = 1;  ///< from 1

  friend bool operator==(const PdoRef&, const PdoRef&) = default;
};

/// The PDOs of one node.
class LoggedPdos {
 public:
  /// With the defaults of CiA 402, and what a data sheet has.
  /// @param sheet nullptr = none; it outlives the PDOs
  LoggedPdos(std::uint8_t node, const canopen::DataSheet* sheet);

  /// The node is as after power-up.
  void reset();

  /// Takes what the master has read or written.
  /// @return whether it was a parameter of a PDO
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
