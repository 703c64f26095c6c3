// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "directory.hpp"
#include "vdrive_messages.h"

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <vector>

namespace vdrive::client {

/// Which axes this session holds, and the epoch and the sequence number of its next command frame
/// to each bench. Thread-safe; sends nothing.
class Holdings {
 public:
  explicit Holdings(std::uint64_t session) : session_(session) {}

  /// Locks the order of what is sent to a bench: one sender at a time numbers and sends its frames,
  /// and no frame is sent during a request that may change the epoch. A bench that does not answer
  /// delays no frame to another.
  ///
  /// Order of locks in a session: this one, the link to the bench (Connection::open), the lock of
  /// one state. The lock of a state is held for a few instructions and inside of it no other is
  /// taken.
  [[nodiscard]] std::unique_lock<std::mutex> lock_sending(std::uint32_t bench);

  /// The same without waiting. @return no lock when another thread sends.
  [[nodiscard]] std::unique_lock<std::mutex> try_lock_sending(std::uint32_t bench);

  /// The bench answered that these axes are held in `epoch`.
  /// @param lives_by_wall_clock whether it takes them away from a session that is silent
  void note_acquired(const BenchKey& key, std::span<const std::uint16_t> axes, std::uint32_t epoch,
                     bool lives_by_wall_clock);

  /// A frame of the present epoch that is refused as a whole shows that control is lost.
  void note_answer(const msg::CommandReply& reply);

  /// @return whether this session took all of these and has not received the loss of them.
  [[nodiscard]] bool holds(const BenchKey& key, std::span<const std::uint16_t> axes);

  /// @return the runs in which this session holds axes. From now on it holds none.
  [[nodiscard]] std::vector<BenchKey> drop_all();

  /// @return the run of this bench in which this session holds axes; nothing when it holds none.
  ///         From now on it holds none there.
  [[nodiscard]] std::optional<BenchKey> drop(std::uint32_t bench);

  /// @return the runs that need a keep-alive.
  [[nodiscard]] std::vector<BenchKey> to_keep_alive() const;

  /// @return an empty frame with the next sequence number. With lock_sending of its bench.
  [[nodiscard]] msg::CommandFrame next_frame(const BenchKey& key);

  /// @return the same; nothing when this session holds axes in another run of the service by now.
  [[nodiscard]] std::optional<msg::CommandFrame> next_keep_alive(const BenchKey& key);

  /// @return the number of the last frame, 0 = none.
  [[nodiscard]] std::uint64_t last_sequence(const BenchKey& key);

 private:
  /// What this session has from one run of a service.
  struct Holding {
    BenchKey key;
    bool lives_by_wall_clock = false;
    std::uint32_t epoch = 0;
    std::uint64_t epoch_since = 0;  ///< first sequence number sent with this epoch
    std::uint64_t sequence = 0;     ///< last one sent
    std::set<std::uint16_t> axes;
  };

  std::mutex& send_mutex_of(std::uint32_t bench);
  Holding& holding(const BenchKey& key);
  msg::CommandFrame frame_of(Holding& held) const;

  const std::uint64_t session_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::map<std::uint32_t, Holding> holdings_;
  std::map<std::uint32_t, std::mutex> send_mutexes_;  ///< stay where they are when one is added
};

}  // namespace vdrive::client
