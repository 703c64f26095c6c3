// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "announcement.hpp"
#include "datagram_check.hpp"
#include "dds/library/library.hpp"
#include "deletion_gate.hpp"
#include "lease_keeper.hpp"
#include "returned_participants.hpp"
#include "returned_servers.hpp"
#include "silent_readers.hpp"
#include "vdrive/wire/guard.hpp"
#include "vdrive/wire/participant.hpp"
#include "writer_numbers.hpp"

#include <array>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::wire {

/// Stands between the transports of a participant and the library: keeps away what the library does
/// not survive, and judges which participants are gone. Thread-safe.
class Guard {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;
  using Locator = rtps::Locator_t;

  explicit Guard(const NetworkSettings& settings);
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// A channel opens; the library takes what arrives by it until it closes.
  void open(const Locator& local, Receiver* channel);

  /// The library takes datagrams from now on. What has arrived before waits for this. Fast DDS 2.9
  /// and 3.1 (RTPSParticipantImpl::enable): the library announces a participant some 0.1 ms before
  /// it reads what arrives, and an answer that it does not read is repeated after 0.1 to 1 s.
  void begin();

  /// The channel of `local` closes: returns when nothing is handed over to it any more.
  void close(const Locator& local);

  /// Hands a datagram over to the library, or does not. Waits for begin(), or for the first channel
  /// that closes.
  void receive(Receiver& channel, ByteView datagram, const Locator& local, const Locator& remote);

  /// The library sends a datagram.
  /// @param renumbered holds a changed copy where one is needed
  /// @return what leaves.
  [[nodiscard]] ByteView sends(ByteView datagram, std::vector<std::uint8_t>& renumbered);

  /// What is received waits while a reader or a writer is deleted.
  [[nodiscard]] DeletionGate& deletions() noexcept { return deletions_; }

  /// The library has found a participant, and has no readers for its writers yet.
  /// @return whether it has announced DDS Security.
  bool found(const GuidPrefix& participant);

  /// The library has removed a participant and its readers for it.
  void lost(const GuidPrefix& participant);

  [[nodiscard]] GuardCounts counts() const;

 private:
  using Keeper = LeaseKeeper<Receiver*>;
  using Clock = Keeper::Clock;

  void refuse(Refusal refusal, const Locator& remote);
  [[nodiscard]] std::optional<ByteView> with_plausible_numbers(
      ByteView datagram, Clock::time_point now, const Locator& remote,
      std::vector<std::uint8_t>& renumbered);
  void note_greetings(ByteView datagram);
  [[nodiscard]] bool comes_too_early(ByteView datagram, Clock::time_point now) const;
  void hand_over(Receiver& channel, ByteView datagram, const Locator& local, const Locator& remote);
  void pass_discovery(Receiver& channel, ByteView datagram, const Locator& local,
                      const Locator& remote);
  [[nodiscard]] bool passes(const Submessage& submessage, std::vector<std::uint8_t>& datagram,
                            Receiver& channel, const Locator& remote);
  [[nodiscard]] Refusal take_announcement(const Announcement& announcement,
                                          const GuidPrefix& sender, Receiver& channel);
  void judge();
  void remove_silent();
  void remove(const Keeper::Silent& silent);
  void acknowledge_for_silent();
  [[nodiscard]] std::optional<Locator> locator_of(const Receiver* channel);

  const Role role_;
  const Mode mode_;
  const bool keeps_leases_;
  const bool raises_leases_;  ///< the library's timers never fire
  const GuardSink sink_;

  std::array<std::atomic<std::uint64_t>, kRefusals> refused_{};
  std::atomic<std::uint64_t> handed_over_{0};
  std::atomic<std::uint64_t> ignored_{0};
  std::atomic<std::uint64_t> judged_{0};
  std::atomic<std::uint64_t> held_back_{0};
  WriterNumbers numbers_;

  mutable std::mutex keeper_mutex_;
  Keeper keeper_;
  ReturnedParticipants returned_;
  ReturnedServers servers_;
  SilentReaders<Receiver*> silent_readers_;
  std::set<GuidPrefix> closed_;            ///< those of the keeper that have announced DDS Security
  std::atomic<bool> has_returned_{false};  ///< `returned_` is not empty: seen without the lock

  std::atomic<bool> has_begun_{false};  ///< or the library gave up before
  /// A participant announces itself by several channels. The library ignores the second
  /// announcement at once, while the first is still being worked on in another thread, and so it
  /// would ignore what that participant sends next. It also works on a participant that it adds
  /// after it has released its lock: a removal waits for that. Fast DDS 2.9 and 3.1, where 3.1
  /// works on a copy, and could bring back the endpoints of a participant that has just been
  /// removed.
  std::mutex announcing_;

  DeletionGate deletions_;   ///< before all locks of this class but `keeper_mutex_`
  std::mutex handing_over_;  ///< a removal is on its way through a channel
  std::mutex channels_mutex_;
  std::map<Locator, Receiver*> channels_;

  std::mutex end_mutex_;
  std::condition_variable end_changed_;
  bool ends_ = false;
  std::thread judge_;
};

}  // namespace vdrive::wire
