// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

namespace vdrive::canopen {

/// The communication parameters of a node, which are the writable objects that the node itself has:
/// what 1010h:01 has saved of them and 1011h:01 forgets (CiA 301, 7.5.2.13 and 7.5.2.14), and the
/// values in force of those that no other part of the node has, such as 1029h:01.
class CommunicationParameters {
 public:
  using Values = std::map<ObjectAddress, std::uint32_t>;
  using Read = std::function<std::uint32_t(ObjectAddress object)>;
  using Write = std::function<AbortCode(ObjectAddress object, std::uint32_t value)>;

  /// @param stored what is no communication parameter is left out
  CommunicationParameters(std::uint8_t node_id, Values stored);

  /// @return whether there is such an object, and it is a communication parameter.
  [[nodiscard]] static bool has(ObjectAddress object);

  /// What is stored, where it is not the default.
  [[nodiscard]] const Values& stored() const noexcept { return stored_; }

  /// @param in_force gives the value of a parameter that is in force now
  /// @return what 1010h:01 has to store: those that are not the default.
  [[nodiscard]] Values to_store(const Read& in_force) const;

  /// From the next reset on each parameter has the value that is stored here, or its default.
  void set_stored(Values values) noexcept { stored_ = std::move(values); }

  /// After a reset, when each parameter has its default: writes what is stored, in an order that
  /// the rules for COB-IDs and mappings allow. A value that is refused is left out: the parameter
  /// keeps its default, and the others do not suffer. A PDO whose mapping is refused is not valid.
  /// @param write writes a parameter as a master does
  void restore(const Write& write) const;

  /// Of a parameter that no other part of the node has: the value in force.
  /// @pre has(object)
  [[nodiscard]] std::uint32_t value(ObjectAddress object) const;
  void set_value(ObjectAddress object, std::uint32_t value);

  /// They have their defaults again.
  void reset() noexcept { in_force_.clear(); }

 private:
  /// @return what a parameter has after the next reset.
  [[nodiscard]] std::uint32_t restored(ObjectAddress object) const;
  void restore_index(std::uint16_t index, const Write& write) const;
  void restore_pdo(std::uint16_t parameters, const Write& write) const;
  void restore_mapping(std::uint16_t index, const Write& write) const;
  void restore_cob_id(ObjectAddress object, const Write& write) const;

  std::uint8_t node_id_;
  Values stored_;
  Values in_force_;  ///< those that are not the default
};

}  // namespace vdrive::canopen
