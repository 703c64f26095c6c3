// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::canopen {

/// Kinds of faults between a node and its bus.
enum class BusFaultKind : std::uint8_t {
  lost,       ///< frames do not arrive
  late,       ///< frames arrive after `delay`; others overtake them
  doubled,    ///< frames arrive twice
  duplicate,  ///< a second device has the same node id
  bus_off,    ///< the CAN controller of the node is bus-off
};

/// As seen from the node.
enum class FrameDirection : std::uint8_t { received, sent };

/// A fault of the bus, in drive time.
struct BusFault {
  BusFaultKind kind{};
  std::uint8_t node = 0;                      ///< node id; 0 = every node
  unsigned percent = 100;                     ///< share of the frames: lost, late and doubled
  std::optional<FrameDirection> direction{};  ///< lost, late and doubled; none = both
  DriveTime delay{};                          ///< late
  std::uint64_t seed = 0;                     ///< determines which frames are affected
  DriveTime from{};
  std::optional<DriveTime> until{};  ///< exclusive; none = until it is cleared

  friend bool operator==(const BusFault&, const BusFault&) = default;
};

/// The effect of the faults on a frame.
struct FrameFate {
  bool is_lost = false;
  bool is_doubled = false;
  DriveTime delay{};

  friend bool operator==(const FrameFate&, const FrameFate&) = default;
};

/// Parses a fault in the syntax of the command line, the configuration and the gateway:
///
///     KIND [PERCENT%] [sent | received] [seed N] [from T] [for T]
///     KIND = lost | late T | doubled | duplicate | bus_off
///
/// such as "late 4ms 10% sent seed 7 from 2s for 500ms". `from` is drive time since the start of
/// the bench if SYNC steps it, otherwise since the first nodes joined the bus; the default is
/// `now`.
/// @return the fault, for every node, or why `text` is not valid, with the allowed values
[[nodiscard]] std::variant<BusFault, std::string> parse_bus_fault(std::string_view text,
                                                                  DriveTime now);

/// Parses the same syntax with a leading node id, such as "3 lost 5%"; without one, for every node.
[[nodiscard]] std::variant<BusFault, std::string> parse_fault_of_node(std::string_view text);

/// The faults of a bus. Their effect on a frame depends only on seed, number, direction and drive
/// time, so that they affect the same frames in a repeated run.
class BusFaults final {
 public:
  static constexpr std::size_t kMostFaults = 64;

  /// Adds a fault, and removes expired ones.
  /// @return false if there are kMostFaults already
  [[nodiscard]] bool add(const BusFault& fault, DriveTime now);

  /// @param node 0 = all faults
  void clear(std::uint8_t node);

  [[nodiscard]] bool empty() const noexcept { return faults_.empty(); }

  /// A fault for every node affects a given frame in the same way at each node.
  /// @param number of the frame, counted per direction
  [[nodiscard]] FrameFate fate_of(std::uint8_t node, FrameDirection direction, std::uint64_t number,
                                  DriveTime now);

  /// @return whether a fault of this kind acts on the node now.
  [[nodiscard]] bool acts(BusFaultKind kind, std::uint8_t node, DriveTime now) const;

  /// Advances the drive time of the faults, as in BusFault::from.
  void pass_to(DriveTime now) noexcept { now_ = std::max(now_, now); }

  /// @return the latest time passed to pass_to().
  [[nodiscard]] DriveTime now() const noexcept { return now_; }

  /// @return the number of affected frames, counted for each recipient.
  [[nodiscard]] std::uint64_t disturbed_frames() const noexcept { return disturbed_; }

 private:
  std::vector<BusFault> faults_;
  DriveTime now_{};
  std::uint64_t disturbed_ = 0;
};

}  // namespace vdrive::canopen
