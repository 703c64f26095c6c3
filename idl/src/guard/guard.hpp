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

/// Stands between the transports of a participant and the library: withholds datagrams that the
/// library would not survive, and decides which participants are gone. Thread-safe.
class Guard {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;
  using Locator = rtps::Locator_t;

  explicit Guard(const NetworkSettings& settings);
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// A channel opens; the library accepts what arrives on it until it closes.
  void open(const Locator& local, Receiver* channel);

  /// From now on the library accepts datagrams; earlier ones wait for this call. Fast DDS 2.9 and
  /// 3.1 (RTPSParticipantImpl::enable) announce a participant about 0.1 ms before they read what
  /// arrives, and an answer not read is repeated only after 0.1 to 1 s.
  void begin();

  /// The channel of `local` closes. Returns when no more datagrams are passed to it.
  void close(const Locator& local);

  /// Passes a datagram to the library or refuses it. Waits for begin(), or for the first channel to
  /// close.
  void receive(Receiver& channel, ByteView datagram, const Locator& local, const Locator& remote);

  /// The library sends a datagram.
  /// @param renumbered holds a modified copy, if one is needed
  /// @return the bytes to send.
  [[nodiscard]] ByteView sends(ByteView datagram, std::vector<std::uint8_t>& renumbered);

  /// Makes received data wait while a reader or a writer is deleted.
  [[nodiscard]] DeletionGate& deletions() noexcept { return deletions_; }

  /// The library has found a participant but has no readers for its writers yet.
  /// @return whether the participant has announced DDS Security.
  bool found(const GuidPrefix& participant);

  /// The library has removed a participant and its readers for it.
  void lost(const GuidPrefix& participant);

  [[nodiscard]] GuardCounts counts() const;

  /// @return NetworkSettings::receive_coalescing.
  [[nodiscard]] std::chrono::microseconds receive_coalescing() const noexcept {
    return receive_coalescing_;
  }

 private:
  using Keeper = LeaseKeeper<Receiver*>;
  using Clock = Keeper::Clock;

  void refuse(Refusal refusal, const Locator& remote);
  [[nodiscard]] std::optional<ByteView> with_plausible_numbers(
      ByteView datagram, Clock::time_point now, const Locator& remote,
      std::vector<std::uint8_t>& renumbered);
  void note_initial_acknacks(ByteView datagram);
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
  const bool raises_leases_;  ///< so that the lease timers of the library never fire
  const GuardSink sink_;
  const std::chrono::microseconds receive_coalescing_;

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
  std::set<GuidPrefix> closed_;            ///< those in `keeper_` that have announced DDS Security
  std::atomic<bool> has_returned_{false};  ///< `returned_` is not empty; readable without the lock

  std::atomic<bool> has_begun_{false};  ///< begin() was called, or a channel has closed
  /// Serialises announcements and removals of participants. A participant announces itself on
  /// several channels. The library drops the second announcement while another thread is still
  /// processing the first, and would then also ignore what the participant sends next. When the
  /// library adds a participant, it releases its own lock before it has finished, so a removal must
  /// wait until it has (Fast DDS 2.9 and 3.1; 3.1 works on a copy and could bring back the
  /// endpoints of a participant that has just been removed).
  std::mutex announcing_;

  DeletionGate deletions_;   ///< taken only while no other lock of this class is held
  std::mutex handing_over_;  ///< held while a datagram made by the guard goes through a channel
  std::mutex channels_mutex_;
  std::map<Locator, Receiver*> channels_;

  std::mutex end_mutex_;
  std::condition_variable end_changed_;
  bool ends_ = false;
  std::thread judge_;
};

}  // namespace vdrive::wire
