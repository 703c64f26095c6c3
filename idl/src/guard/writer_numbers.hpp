// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"
#include "vdrive/wire/guard.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

namespace vdrive::wire {

/// The sequence numbers of the writers of other participants.
///
/// A reliable reader of the library walks over all numbers between the last one that it has
/// delivered and the oldest one that its writer still has, one by one and under its lock
/// (StatefulReader::NotifyChanges of Fast DDS 2.9 and 3.1), in Debian's build of 2.9 with a system
/// call for each. A new reader begins at 0. Therefore
/// - a number that is far from all that its writer has sent is refused;
/// - the library reads smaller numbers of a writer that has sent many before it was first heard:
///   they begin at 1 with the oldest sample that the writer still had. What the library
///   acknowledges gets the writer's own numbers again.
///
/// Only participants that the library knows are followed; it ignores writers of others. Without
/// clock; thread-safe.
class WriterNumbers {
 public:
  using Clock = std::chrono::steady_clock;

  /// How far a number may be from what its writer has sent: as far as one GAP reaches.
  static constexpr std::int64_t kReach = 65'536;
  /// The same for a writer without heartbeats. The library takes no step for each of its numbers,
  /// but ignores all smaller ones afterwards. Ten minutes of 100,000 samples a second.
  static constexpr std::int64_t kReachOfBestEffort = std::int64_t{1} << 26U;
  /// The largest number with which a writer of discovery is heard for the first time.
  static constexpr std::int64_t kMostOfDiscovery = std::int64_t{1} << 20U;
  /// A writer that begins below keeps its numbers: their steps take less than 1 ms.
  static constexpr std::int64_t kNear = 1'024;
  /// Numbers that the library may be made to skip in a second, of all writers.
  static constexpr std::int64_t kSkippedInASecond = 4 * kReach;
  static constexpr std::size_t kMostWriters = 256;  ///< of a participant
  /// A writer that is implausible for so long, and never plausible, has skipped the numbers indeed:
  /// this program stood still. A single implausible datagram is forgotten after kMemory.
  static constexpr std::chrono::milliseconds kDoubt{500};
  static constexpr std::chrono::seconds kMemory{5};

  struct Report {
    Refusal refusal = Refusal::none;
    bool is_renumbered = false;  ///< the library reads the changed copy
    /// A participant whose writer has skipped numbers: the library must forget and find it again.
    std::optional<GuidPrefix> astray;
  };

  /// The library has found a participant, and has no readers for its writers yet.
  void found(const GuidPrefix& participant);

  /// The library has removed a participant and its readers for it.
  void removed(const GuidPrefix& participant);

  /// @param datagram that has passed check_datagram
  /// @param renumbered becomes the datagram for the library, where its numbers differ
  [[nodiscard]] Report receive(ByteView datagram, Clock::time_point now,
                               std::vector<std::uint8_t>& renumbered);

  /// The library sends a datagram.
  /// @param renumbered becomes the datagram for the writers, where its numbers differ
  /// @return whether they differ.
  [[nodiscard]] bool send(ByteView datagram, std::vector<std::uint8_t>& renumbered);

 private:
  struct Writer {
    std::int64_t base = 0;     ///< the library reads a number minus this
    std::int64_t highest = 0;  ///< that it has sent
    /// The library has taken its step for all up to here: acknowledged or skipped.
    std::int64_t done = 0;
    bool is_reliable = false;     ///< it has sent heartbeats or gaps
    Clock::time_point doubted{};  ///< the first of its implausible datagrams; 0 = there is none
  };

  using Writers = std::map<EntityId, Writer>;

  struct Numbers;
  struct Answer;

  struct Judgement {
    Refusal refusal = Refusal::none;
    bool is_astray = false;
    std::int64_t base = 0;
  };

  [[nodiscard]] static std::optional<Numbers> numbers_in(const Submessage& submessage);
  [[nodiscard]] static std::optional<Writer> begin(const Numbers& numbers, Submessages rest);
  [[nodiscard]] static Writer* writer_of(Writers& writers, const Numbers& numbers,
                                         Submessages rest);
  [[nodiscard]] static bool is_plausible(const Numbers& numbers, const Writer& writer);
  [[nodiscard]] static bool has_gone_astray(const Numbers& numbers, Writer& writer,
                                            Clock::time_point now);

  [[nodiscard]] bool take(const Numbers& numbers, Writer& writer, Clock::time_point now);
  [[nodiscard]] Judgement judge(const GuidPrefix& source, const Numbers& numbers, Submessages rest,
                                Clock::time_point now);
  [[nodiscard]] static std::optional<Answer> answer_in(const Submessage& submessage);
  [[nodiscard]] std::int64_t pass(const GuidPrefix& receiver, const Answer& answer);
  [[nodiscard]] bool may_skip(std::int64_t count, Clock::time_point now);

  std::mutex mutex_;
  std::map<GuidPrefix, Writers> participants_;
  std::int64_t second_ = 0;   ///< of `skipped_`
  std::int64_t skipped_ = 0;  ///< numbers
};

}  // namespace vdrive::wire
