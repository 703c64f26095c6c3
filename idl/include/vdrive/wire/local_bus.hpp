// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <cstdint>
#include <functional>
#include <memory>

namespace vdrive::wire {

/// The place where participants of one process exchange samples by function calls: no socket, no
/// thread, no file. A sample is delivered in the thread that writes it, before `write` returns, to
/// each subscription of its topic; none is lost. Topics keep what they keep over DDS for
/// subscriptions that come later. Lives as long as its participants do. A process that was forked
/// cannot use the bus of its parent. Thread-safe.
class LocalBus {
 public:
  /// What a bench asks of the threads of its clients.
  struct Work {
    /// Does what waits, as far as another thread does not do it already; does not wait itself.
    /// Ends after some of it: the caller may have what it waits for.
    std::function<LocalWork()> run;
    /// @return whether the bench takes what a client may send next.
    std::function<bool()> has_room;
  };

  LocalBus();
  ~LocalBus();
  LocalBus(const LocalBus&) = delete;
  LocalBus& operator=(const LocalBus&) = delete;

  /// While this object lives, threads of clients that wait for an answer of the bench run its work:
  /// so a bench in lock-step needs no thread. The destructor waits for the threads that run it.
  class WorkPlace {
   public:
    /// @param bench its number, of which the bus has one
    WorkPlace(std::shared_ptr<LocalBus> bus, std::uint32_t bench, Work work);
    ~WorkPlace();
    WorkPlace(const WorkPlace&) = delete;
    WorkPlace& operator=(const WorkPlace&) = delete;

   private:
    std::shared_ptr<LocalBus> bus_;
    std::uint32_t bench_;
  };

  /// Does work of a bench.
  LocalWork run_work(std::uint32_t bench);

  /// Before a client sends to a bench: runs its work when it has no room; where another thread runs
  /// it, waits for that for a moment. @return whether the bench has room.
  bool make_room(std::uint32_t bench);

  struct Parts;  ///< known inside the wire room only

  [[nodiscard]] Parts& parts() noexcept { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::wire
