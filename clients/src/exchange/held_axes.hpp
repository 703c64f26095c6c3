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

/// The axes that a session releases in one run of a service.
struct ReleasedAxes {
  BenchKey key;
  std::vector<std::uint16_t> axes;
  std::vector<std::uint16_t> kept;  ///< running and not seen to stop
};

/// The axes that this session holds, and for each bench the epoch and the sequence number of its
/// next command frame. Thread-safe; sends nothing.
///
/// An axis that a call has set in endless motion (a velocity, a torque, a stream) counts as running
/// until it is seen at rest, or until a call has told the program that it runs on. A running axis
/// is not released, because no watchdog would ever stop a free axis.
class HeldAxes {
 public:
  explicit HeldAxes(std::uint64_t session) : session_(session) {}

  /// Puts the messages to a bench in order: one sender at a time numbers and sends its frames, and
  /// no frame is sent during a request that may change the epoch. A bench that does not answer does
  /// not delay frames to other benches.
  ///
  /// Lock order in a session: this lock, the link to the bench (BenchLinks::open), the lock of one
  /// state. The lock of a state is held for a few instructions, and no other lock is taken under
  /// it.
  [[nodiscard]] std::unique_lock<std::mutex> lock_sending(std::uint32_t bench);

  /// As lock_sending(), without waiting.
  /// @return no lock if another thread is sending.
  [[nodiscard]] std::unique_lock<std::mutex> try_lock_sending(std::uint32_t bench);

  /// Records a bench's answer that this session holds these axes in `epoch`.
  /// @param needs_keep_alive whether the bench takes axes away from a silent session
  /// @return whether the epoch is new: the session has gained an axis, or lost another one.
  bool note_acquired(const BenchKey& key, std::span<const std::uint16_t> axes, std::uint32_t epoch,
                     bool needs_keep_alive);

  /// Evaluates an answer: a completely refused frame of the present epoch shows that control is
  /// lost.
  void note_answer(const msg::CommandReply& reply);

  /// @return whether this session has acquired all of these and has not learned that it lost one.
  [[nodiscard]] bool holds(const BenchKey& key, std::span<const std::uint16_t> axes);

  /// Records that a frame about to be sent sets these axes in motion. Standstill counts only if it
  /// is seen after the frame was applied.
  void note_running(const BenchKey& key, std::span<const std::uint16_t> axes,
                    std::uint64_t sequence);

  [[nodiscard]] bool is_running(const BenchKey& key, std::uint16_t axis);

  /// Records that these axes are not running, or that the program knows that they run on.
  void forget_running(const BenchKey& key, std::span<const std::uint16_t> axes);

  /// Records the state of axes of this run: those at rest, and those taken by another session, are
  /// no longer running.
  void note_seen(const BenchKey& key, std::span<const AxisSnapshot> axes);

  /// Forgets all axes, even those kept: no keep-alives are sent any more, and holds() is false.
  /// @return the axes to release and those kept, by run.
  [[nodiscard]] std::vector<ReleasedAxes> drop_all();

  /// @return as drop_all(), for one bench; nothing if this session holds none of its axes.
  [[nodiscard]] std::optional<ReleasedAxes> drop(std::uint32_t bench);

  /// @return the runs that need keep-alives.
  [[nodiscard]] std::vector<BenchKey> to_keep_alive() const;

  /// @return an empty frame with the next sequence number. Called with lock_sending() of the bench.
  [[nodiscard]] msg::CommandFrame next_frame(const BenchKey& key);

  /// @return as next_frame(); nothing if this session now holds axes in another run of the service.
  [[nodiscard]] std::optional<msg::CommandFrame> next_keep_alive(const BenchKey& key);

  /// @return the number of the last frame, 0 = none.
  [[nodiscard]] std::uint64_t last_sequence(const BenchKey& key);

 private:
  /// The last frame that set an axis in motion, and the first tick in which it was seen to be
  /// applied.
  struct Running {
    std::uint64_t sequence = 0;
    std::optional<std::uint64_t> since{};
  };

  /// The held axes of this session in one run of a service.
  struct Holding {
    BenchKey key;
    bool needs_keep_alive = false;
    std::uint32_t epoch = 0;
    std::uint64_t epoch_since = 0;  ///< first sequence number sent with this epoch
    std::uint64_t sequence = 0;     ///< last one sent
    std::set<std::uint16_t> axes;
    std::map<std::uint16_t, Running> running;
  };

  std::mutex& send_mutex_of(std::uint32_t bench);
  Holding& holding(const BenchKey& key);
  msg::CommandFrame frame_of(Holding& held) const;
  static std::optional<ReleasedAxes> give_back(Holding& held);

  const std::uint64_t session_;
  mutable std::mutex mutex_;  ///< guards the members below
  std::map<std::uint32_t, Holding> held_axes_;
  std::map<std::uint32_t, std::mutex> send_mutexes_;  ///< a map: elements must not move
};

}  // namespace vdrive::client
