// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <vector>

namespace vdrive::client {

/// What a session gives back of one run of a service.
struct GivenBack {
  BenchKey key;
  std::vector<std::uint16_t> axes;
  std::vector<std::uint16_t> kept;  ///< they run and were not seen to stop
};

/// Which axes this session holds, and the epoch and the sequence number of its next command frame
/// to each bench. Thread-safe; sends nothing.
///
/// An axis that a call has set into a motion without an end (a velocity, a torque, a stream) is
/// running until it was seen to rest, or until the program was told that it runs on. A running axis
/// is not given back: free and running, no watchdog would ever stop it.
class Holdings {
 public:
  explicit Holdings(std::uint64_t session) : session_(session) {}

  /// Locks the order of what is sent to a bench: one sender at a time numbers and sends its frames,
  /// and no frame is sent during a request that may change the epoch. A bench that does not answer
  /// delays no frame to another.
  ///
  /// Order of locks in a session: this one, the link to the bench (BenchLinks::open), the lock of
  /// one state. The lock of a state is held for a few instructions and inside of it no other is
  /// taken.
  [[nodiscard]] std::unique_lock<std::mutex> lock_sending(std::uint32_t bench);

  /// The same without waiting. @return no lock when another thread sends.
  [[nodiscard]] std::unique_lock<std::mutex> try_lock_sending(std::uint32_t bench);

  /// The bench answered that these axes are held in `epoch`.
  /// @param lives_by_wall_clock whether it takes them away from a session that is silent
  /// @return whether the epoch is a new one: the session has gained an axis, or lost another one.
  bool note_acquired(const BenchKey& key, std::span<const std::uint16_t> axes, std::uint32_t epoch,
                     bool lives_by_wall_clock);

  /// A frame of the present epoch that is refused as a whole shows that control is lost.
  void note_answer(const msg::CommandReply& reply);

  /// @return whether this session took all of these and has not received the loss of them.
  [[nodiscard]] bool holds(const BenchKey& key, std::span<const std::uint16_t> axes);

  /// A frame that is about to be sent sets these axes into motion. A rest counts when it is seen
  /// after the frame was applied.
  void note_running(const BenchKey& key, std::span<const std::uint16_t> axes,
                    std::uint64_t sequence);

  [[nodiscard]] bool is_running(const BenchKey& key, std::uint16_t axis);

  /// These axes are not running, or the program that let them run knows that they run on.
  void forget_running(const BenchKey& key, std::span<const std::uint16_t> axes);

  /// What axes of this run show: those that rest, and those that another session has taken, are not
  /// running any more.
  void note_seen(const BenchKey& key, std::span<const AxisSnapshot> axes);

  /// @return by run what this session gives back. From now on it sends no keep-alive to them, and
  ///         no call of it relies on an axis that it kept.
  [[nodiscard]] std::vector<GivenBack> drop_all();

  /// @return the same of one bench; nothing when this session holds no axis of it.
  [[nodiscard]] std::optional<GivenBack> drop(std::uint32_t bench);

  /// @return the runs that need a keep-alive.
  [[nodiscard]] std::vector<BenchKey> to_keep_alive() const;

  /// @return an empty frame with the next sequence number. With lock_sending of its bench.
  [[nodiscard]] msg::CommandFrame next_frame(const BenchKey& key);

  /// @return the same; nothing when this session holds axes in another run of the service by now.
  [[nodiscard]] std::optional<msg::CommandFrame> next_keep_alive(const BenchKey& key);

  /// @return the number of the last frame, 0 = none.
  [[nodiscard]] std::uint64_t last_sequence(const BenchKey& key);

 private:
  /// The last frame that set an axis into motion, and the tick in which it was applied.
  struct Running {
    std::uint64_t sequence = 0;
    std::optional<std::uint64_t> since{};
  };

  /// What this session has from one run of a service.
  struct Holding {
    BenchKey key;
    bool lives_by_wall_clock = false;
    std::uint32_t epoch = 0;
    std::uint64_t epoch_since = 0;  ///< first sequence number sent with this epoch
    std::uint64_t sequence = 0;     ///< last one sent
    std::set<std::uint16_t> axes;
    std::map<std::uint16_t, Running> running;
  };

  std::mutex& send_mutex_of(std::uint32_t bench);
  Holding& holding(const BenchKey& key);
  msg::CommandFrame frame_of(Holding& held) const;
  static std::optional<GivenBack> give_back(Holding& held);

  const std::uint64_t session_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::map<std::uint32_t, Holding> holdings_;
  std::map<std::uint32_t, std::mutex> send_mutexes_;  ///< stay where they are when one is added
};

}  // namespace vdrive::client
