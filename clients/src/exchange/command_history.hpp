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

/// The command that a call has given to an axis: what later ones are compared with.
struct GivenCommand {
  std::uint64_t sequence = 0;                ///< of its frame, 0 = none was sent
  OperatingMode mode = OperatingMode::none;  ///< that it acts in
};

/// @return whether the command sets a mode, hands over a set-point or leaves Operation enabled: it
///         ends what the axis did before.
[[nodiscard]] bool ends_motion(const msg::AxisCommand& command) noexcept;

/// The last commands of this session to each axis that end what the axis did before, whichever
/// thread gave them. Commands of other sessions show in the owner of the axis. Thread-safe; sends
/// nothing.
class CommandHistory {
 public:
  /// A frame is about to be sent.
  void note_frame(const BenchKey& key, const msg::CommandFrame& frame);

  /// Forgets what a bench has refused of a frame, and set-points that an axis ignored.
  void note_answer(const msg::CommandReply& reply);

  /// A request of this session was carried out.
  /// @param last_sequence number of the last frame before it
  void note_request(const BenchKey& key, const msg::Request& request, const msg::Reply& reply,
                    std::uint64_t last_sequence);

  /// This session has these axes only now, or again.
  void note_gained(const BenchKey& key, std::span<const std::uint16_t> axes,
                   std::uint64_t last_sequence);

  /// @param seen the axis in or after the tick in which the command was in force
  /// @return what has ended `given`, such as "homing mode (6060h = 6)"; nothing when nothing has.
  [[nodiscard]] std::optional<std::string> find_end(const BenchKey& key, const GivenCommand& given,
                                                    const AxisSnapshot& seen) const;

 private:
  /// One command to one axis.
  struct Entry {
    std::uint64_t after = 0;  ///< number of the last frame before it
    std::uint64_t tick = 0;   ///< of a request: in which it is in force; 0 = it is a frame
    bool is_whole = false;    ///< its frame is carried out whole or not at all
    std::optional<OperatingMode> mode{};         ///< 6060h
    std::optional<std::uint16_t> controlword{};  ///< 6040h, where it ends something
    std::optional<std::int32_t> target{};        ///< 607Ah, handed over with it
    std::vector<ObjectAddress> written{};        ///< set-points of modes without a handshake
    std::string_view what{};                     ///< something else
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
  static void take_back(Entry& entry, std::uint16_t axis, const msg::CommandReply& reply);
  static void forget_refused(Entries& entries, std::uint16_t axis, const msg::CommandReply& reply);
  void add(const BenchKey& key, std::uint16_t axis, Entry entry);

  mutable std::mutex mutex_;  ///< guards what follows
  std::map<std::uint32_t, OfBench> benches_;
};

}  // namespace vdrive::client
