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

/// What goes wrong between a node and its bus.
enum class BusFaultKind : std::uint8_t {
  lost,       ///< frames do not arrive
  late,       ///< frames arrive after `delay`, others overtake them
  doubled,    ///< frames arrive twice
  duplicate,  ///< a second device has the id of the node
  bus_off,    ///< the controller of the node has switched itself off
};

/// As the node sees it.
enum class FrameDirection : std::uint8_t { received, sent };

/// A fault of the bus, in drive time.
struct BusFault {
  BusFaultKind kind{};
  std::uint8_t node = 0;                      ///< node id; 0 = every node
  unsigned percent = 100;                     ///< of the frames; of lost, late and doubled
  std::optional<FrameDirection> direction{};  ///< likewise; none = both
  DriveTime delay{};                          ///< of late
  std::uint64_t seed = 0;                     ///< which frames it hits
  DriveTime from{};
  std::optional<DriveTime> until{};  ///< no longer; none = until it is cleared

  friend bool operator==(const BusFault&, const BusFault&) = default;
};

/// What becomes of a frame.
struct FrameFate {
  bool is_lost = false;
  bool is_doubled = false;
  DriveTime delay{};

  friend bool operator==(const FrameFate&, const FrameFate&) = default;
};

/// Reads a fault as the command line, the configuration and the gateway write it:
///
///     KIND [PERCENT%] [sent | received] [seed N] [from T] [for T]
///     KIND = lost | late T | doubled | duplicate | bus_off
///
/// such as "late 4ms 10% sent seed 7 from 2s for 500ms". `from` is drive time since the bench began
/// where SYNC steps it, else since the first nodes came to the bus; without it `now`.
/// @return the fault of every node, or why `text` is none, with what it may be
[[nodiscard]] std::variant<BusFault, std::string> parse_bus_fault(std::string_view text,
                                                                  DriveTime now);

/// The same with the id of the node before it, such as "3 lost 5%"; without one of every node.
[[nodiscard]] std::variant<BusFault, std::string> parse_fault_of_node(std::string_view text);

/// The faults of a bus. What they do to a frame depends on seed, number, direction and drive time
/// alone: the same run has the same frames.
class BusFaults final {
 public:
  static constexpr std::size_t kMostFaults = 64;

  /// Forgets those that are over.
  /// @return false when there are kMostFaults already
  [[nodiscard]] bool add(const BusFault& fault, DriveTime now);

  /// @param node 0 = all faults
  void clear(std::uint8_t node);

  [[nodiscard]] bool empty() const noexcept { return faults_.empty(); }

  /// A fault of every node does the same to a frame at each of them.
  /// @param number of the frame, counted in its direction
  [[nodiscard]] FrameFate fate_of(std::uint8_t node, FrameDirection direction, std::uint64_t number,
                                  DriveTime now);

  /// @return whether a fault of this kind acts on the node now.
  [[nodiscard]] bool acts(BusFaultKind kind, std::uint8_t node, DriveTime now) const;

  /// Drive time has passed for nodes of the bus, as `from` of a fault counts it.
  void pass_to(DriveTime now) noexcept { now_ = std::max(now_, now); }

  /// @return what pass_to() was told last, of the nodes that are the furthest.
  [[nodiscard]] DriveTime now() const noexcept { return now_; }

  /// @return frames that were not left alone, each where it was to arrive.
  [[nodiscard]] std::uint64_t disturbed_frames() const noexcept { return disturbed_; }

 private:
  std::vector<BusFault> faults_;
  DriveTime now_{};
  std::uint64_t disturbed_ = 0;
};

}  // namespace vdrive::canopen
