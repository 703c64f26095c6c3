// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::canopen {

/// Finds the recipients of a frame by its identifier: most frames on a bus are for none of the
/// nodes added here, and few are for more than one of them. Too many recipients do no harm, because
/// a node ignores frames that are not for it.
class Listeners {
 public:
  /// The recipients of a frame.
  enum class Kind : std::uint8_t { nobody, one, everybody };

  struct Answer {
    Kind kind = Kind::everybody;
    std::size_t place = 0;  ///< if kind is `one`
  };

  /// Identifiers that a node listens to in addition to its SDO requests and to frames for all
  /// nodes.
  struct Listener {
    std::uint8_t id = 0;
    std::span<const std::uint16_t> identifiers;  ///< 11 bits: RPDOs, SYNC, heartbeats of producers
  };

  /// Starts without listeners: only frames for all nodes are delivered.
  Listeners() { clear(); }

  void clear();

  /// Adds the node at `place`, below kMostPlaces.
  void add(std::size_t place, const Listener& listener);

  [[nodiscard]] Answer find(const Frame& frame) const noexcept;

  static constexpr std::size_t kMostPlaces = 127;

 private:
  static constexpr std::uint8_t kNobody = 0x80;
  static constexpr std::uint8_t kEverybody = 0x81;

  std::array<std::uint8_t, kHighestBaseId + 1> whom_{};  ///< place, kNobody or kEverybody
};

}  // namespace vdrive::canopen
