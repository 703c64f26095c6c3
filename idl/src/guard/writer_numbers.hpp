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
/// A reliable reader of the library walks through all numbers from the last one delivered to the
/// oldest one that its writer still has, one by one and under its lock
/// (StatefulReader::NotifyChanges of Fast DDS 2.9 and 3.1), in Debian's build of 2.9 with a system
/// call for each. A new reader starts at 0. Therefore
/// - a number far from all that its writer has sent is refused;
/// - if a writer has sent many samples before it is first heard, the library gets smaller numbers,
///   which start at 1 with the oldest sample that the writer still had. In the library's
///   acknowledgements the writer's own numbers are restored.
///
/// Only participants that the library knows are followed; it ignores writers of others. Time is an
/// argument. Thread-safe.
class WriterNumbers {
 public:
  using Clock = std::chrono::steady_clock;

  /// How far a number may be from what its writer has sent: as far as one GAP can reach.
  static constexpr std::int64_t kReach = 65'536;
  /// The same for a writer without heartbeats. The library does not process its numbers one by one,
  /// but afterwards ignores all smaller ones. Ten minutes at 100,000 samples per second.
  static constexpr std::int64_t kReachOfBestEffort = std::int64_t{1} << 26U;
  /// The largest number with which a discovery writer may first be heard.
  static constexpr std::int64_t kMostOfDiscovery = std::int64_t{1} << 20U;
  /// A writer that starts below this keeps its numbers: processing them takes less than 1 ms.
  static constexpr std::int64_t kNear = 1'024;
  /// How many numbers the library may be made to skip per second, over all writers.
  static constexpr std::int64_t kSkippedInASecond = 4 * kReach;
  static constexpr std::size_t kMostWriters = 256;  ///< per participant
  /// A writer that is implausible for this long, and never plausible in between, really has sent
  /// the skipped numbers, while this program was stopped. A single implausible datagram is
  /// forgotten after kMemory.
  static constexpr std::chrono::milliseconds kDoubt{500};
  static constexpr std::chrono::seconds kMemory{5};

  struct Report {
    Refusal refusal = Refusal::none;
    bool is_renumbered = false;  ///< the library reads the changed copy
    /// A participant with a writer that has skipped numbers: the library must forget it and find it
    /// again.
    std::optional<GuidPrefix> needs_resync;
  };

  /// The library has found a participant but has no readers for its writers yet.
  void found(const GuidPrefix& participant);

  /// The library has removed a participant and its readers for it.
  void removed(const GuidPrefix& participant);

  /// @param datagram one that has passed check_datagram
  /// @param renumbered set to the datagram for the library if its numbers differ
  [[nodiscard]] Report receive(ByteView datagram, Clock::time_point now,
                               std::vector<std::uint8_t>& renumbered);

  /// The library sends a datagram.
  /// @param renumbered set to the datagram for the writers if its numbers differ
  /// @return whether they differ.
  [[nodiscard]] bool send(ByteView datagram, std::vector<std::uint8_t>& renumbered);

 private:
  struct Writer {
    std::int64_t base = 0;     ///< subtracted from each number for the library
    std::int64_t highest = 0;  ///< highest number that it has sent
    /// All numbers up to here are processed by the library: acknowledged or skipped.
    std::int64_t done = 0;
    bool is_reliable = false;     ///< it has sent heartbeats or gaps
    Clock::time_point doubted{};  ///< time of its first implausible datagram; 0 = none
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
  [[nodiscard]] static bool has_jumped(const Numbers& numbers, Writer& writer,
                                       Clock::time_point now);

  [[nodiscard]] bool take(const Numbers& numbers, Writer& writer, Clock::time_point now);
  [[nodiscard]] Judgement judge(const GuidPrefix& source, const Numbers& numbers, Submessages rest,
                                Clock::time_point now);
  [[nodiscard]] static std::optional<Answer> answer_in(const Submessage& submessage);
  [[nodiscard]] std::int64_t pass(const GuidPrefix& receiver, const Answer& answer);
  [[nodiscard]] bool may_skip(std::int64_t count, Clock::time_point now);

  std::mutex mutex_;
  std::map<GuidPrefix, Writers> participants_;
  std::int64_t second_ = 0;   ///< to which `skipped_` applies
  std::int64_t skipped_ = 0;  ///< numbers
};

}  // namespace vdrive::wire
