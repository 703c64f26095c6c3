// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// The command that a call has given to an axis; later commands are compared with it.
struct GivenCommand {
  std::uint64_t sequence = 0;                ///< of its frame, 0 = none was sent
  OperatingMode mode = OperatingMode::none;  ///< the mode in which it acts
};

/// @return whether the command sets a mode, hands over a set-point or leaves Operation enabled, and
///         so ends the previous motion.
[[nodiscard]] bool ends_motion(const msg::AxisCommand& command) noexcept;

/// For each axis, the last commands of this session that end the previous motion, whichever thread
/// gave them. A command of another session shows in the owner of the axis. Thread-safe; sends
/// nothing.
class CommandHistory {
 public:
  /// Records a frame that is about to be sent.
  void note_frame(const BenchKey& key, const msg::CommandFrame& frame);

  /// Removes the parts of a frame that a bench has refused, and set-points that an axis ignored.
  void note_answer(const msg::CommandReply& reply);

  /// Records a request of this session that was carried out.
  /// @param last_sequence number of the last frame before it
  void note_request(const BenchKey& key, const msg::Request& request, const msg::Reply& reply,
                    std::uint64_t last_sequence);

  /// Records that this session has acquired these axes, possibly again.
  void note_gained(const BenchKey& key, std::span<const std::uint16_t> axes,
                   std::uint64_t last_sequence);

  /// @param seen the axis in the tick in which the command took effect, or later
  /// @return what ended `given`, such as "homing mode (6060h = 6)"; nothing if nothing did.
  [[nodiscard]] std::optional<std::string> find_end(const BenchKey& key, const GivenCommand& given,
                                                    const AxisSnapshot& seen) const;

 private:
  /// One command to one axis.
  struct Entry {
    std::uint64_t after = 0;      ///< number of the last frame before it
    std::uint64_t tick = 0;       ///< of a request: in which it took effect; 0 = this is a frame
    bool all_or_nothing = false;  ///< its frame has FRAME_ALL_OR_NOTHING
    std::optional<OperatingMode> mode{};         ///< 6060h
    std::optional<std::uint16_t> controlword{};  ///< 6040h, if it ends a motion
    std::optional<std::int32_t> target{};        ///< 607Ah, handed over with the controlword
    std::vector<ObjectAddress> written{};        ///< set-points of modes without a handshake
    std::string_view what{};                     ///< any other command
  };

  using Entries = std::deque<Entry>;

  struct OfBench {
    std::uint64_t incarnation = 0;
    std::map<std::uint16_t, Entries> axes;  ///< axis 0: all of them
  };

  void note_writes(const BenchKey& key, const msg::Request& request, const msg::Reply& reply,
                   std::uint64_t last_sequence);
  static Entry entry_of(const msg::AxisCommand& command);
  static Entry entry_of(const msg::ObjectAccess& access);
  static bool is_in_force(const Entry& entry, const AxisSnapshot& seen);
  static bool ends(const Entry& entry, OperatingMode mode);
  static std::string text_of(const Entry& entry, OperatingMode mode);
  static void remove_refused(Entry& entry, std::uint16_t axis, const msg::CommandReply& reply);
  static void forget_refused(Entries& entries, std::uint16_t axis, const msg::CommandReply& reply);
  void add(const BenchKey& key, std::uint16_t axis, Entry entry);

  mutable std::mutex mutex_;  ///< guards the members below
  std::map<std::uint32_t, OfBench> benches_;
};

}  // namespace vdrive::client
