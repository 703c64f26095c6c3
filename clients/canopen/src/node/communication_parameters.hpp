// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

namespace vdrive::canopen {

/// The communication parameters of a node: all writable objects that belong to the node itself.
/// Keeps the values saved by 1010h:01 and cleared by 1011h:01 (CiA 301, 7.5.2.13 and 7.5.2.14), and
/// the values in force of parameters that no other part of the node holds, such as 1029h:01.
class CommunicationParameters {
 public:
  using Values = std::map<ObjectAddress, std::uint32_t>;
  using Read = std::function<std::uint32_t(ObjectAddress object)>;
  using Write = std::function<AbortCode(ObjectAddress object, std::uint32_t value)>;

  /// @param stored entries that are not communication parameters are ignored
  CommunicationParameters(std::uint8_t node_id, Values stored);

  /// @return whether `object` exists and is a communication parameter.
  [[nodiscard]] static bool has(ObjectAddress object);

  /// The stored values that differ from their defaults.
  [[nodiscard]] const Values& stored() const noexcept { return stored_; }

  /// @param in_force returns the current value of a parameter
  /// @return the values that 1010h:01 has to store: those that differ from their defaults.
  [[nodiscard]] Values to_store(const Read& in_force) const;

  /// From the next reset on, each parameter has its value in `values`, or else its default.
  void set_stored(Values values) noexcept { stored_ = std::move(values); }

  /// After a reset, when all parameters have their defaults: writes the stored values in an order
  /// that the rules for COB-IDs and mappings allow. A parameter whose stored value is refused keeps
  /// its default; the others are not affected. A PDO whose mapping is refused is not valid.
  /// @param write writes a parameter as a master does
  void restore(const Write& write) const;

  /// The value in force of a parameter that no other part of the node holds.
  /// @pre has(object)
  [[nodiscard]] std::uint32_t value(ObjectAddress object) const;
  void set_value(ObjectAddress object, std::uint32_t value);

  /// Sets the values in force back to their defaults.
  void reset() noexcept { in_force_.clear(); }

 private:
  /// @return the value of a parameter after the next reset.
  [[nodiscard]] std::uint32_t restored(ObjectAddress object) const;
  void restore_index(std::uint16_t index, const Write& write) const;
  void restore_pdo(std::uint16_t parameters, const Write& write) const;
  void restore_mapping(std::uint16_t index, const Write& write) const;
  void restore_cob_id(ObjectAddress object, const Write& write) const;

  std::uint8_t node_id_;
  Values stored_;
  Values in_force_;  ///< values that differ from their defaults
};

}  // namespace vdrive::canopen
