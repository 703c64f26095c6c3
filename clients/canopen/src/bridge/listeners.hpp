// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::canopen {

/// Which nodes of a group a frame is for, by its identifier: of the frames of a bus most are for
/// nobody here, and few for more than one node. A frame that it gives to too many does no harm: a
/// node ignores what is not for it.
class Listeners {
 public:
  /// Whom a frame reaches.
  enum class Kind : std::uint8_t { nobody, one, everybody };

  struct Answer {
    Kind kind = Kind::everybody;
    std::size_t place = 0;  ///< where it is one
  };

  /// What a node listens to in addition to its SDO requests and what is for all nodes.
  struct Listener {
    std::uint8_t id = 0;
    std::span<const std::uint16_t> identifiers;  ///< 11 bits: RPDOs, SYNC, heartbeats of producers
  };

  /// Nobody listens to anything that is not for all nodes.
  Listeners() { clear(); }

  void clear();

  /// Adds the node at `place`, which is below kMostPlaces.
  void add(std::size_t place, const Listener& listener);

  [[nodiscard]] Answer find(const Frame& frame) const noexcept;

  static constexpr std::size_t kMostPlaces = 127;

 private:
  static constexpr std::uint8_t kNobody = 0x80;
  static constexpr std::uint8_t kEverybody = 0x81;

  std::array<std::uint8_t, kHighestBaseId + 1> whom_{};  ///< place, kNobody or kEverybody
};

}  // namespace vdrive::canopen
