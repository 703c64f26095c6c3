// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <cstdint>
#include <functional>
#include <memory>

namespace vdrive::wire {

/// Exchanges samples between participants in one process by function calls, without a socket,
/// thread or file. A sample is delivered in the thread that writes it, before `write` returns, to
/// each subscription of its topic; none is lost. Topics keep the same history for late
/// subscriptions as over DDS. Lives as long as its participants. A forked process cannot use the
/// bus of its parent. Thread-safe.
class LocalBus {
 public:
  /// The work of a bench, done by the threads of its clients.
  struct Work {
    /// Does pending work, unless another thread is doing it; does not wait. May return before all
    /// of it is done, because the caller may already have what it waits for.
    std::function<LocalWork()> run;
    /// @return whether the bench can accept the next message of a client.
    std::function<bool()> has_room;
  };

  LocalBus();
  ~LocalBus();
  LocalBus(const LocalBus&) = delete;
  LocalBus& operator=(const LocalBus&) = delete;

  /// While this object exists, client threads waiting for an answer of the bench run its work, so
  /// that a bench in lock-step needs no thread of its own. The destructor waits for the threads
  /// that are running it.
  class WorkPlace {
   public:
    /// @param bench its number, unique on the bus
    WorkPlace(std::shared_ptr<LocalBus> bus, std::uint32_t bench, Work work);
    ~WorkPlace();
    WorkPlace(const WorkPlace&) = delete;
    WorkPlace& operator=(const WorkPlace&) = delete;

   private:
    std::shared_ptr<LocalBus> bus_;
    std::uint32_t bench_;
  };

  /// Does some work of a bench.
  LocalWork run_work(std::uint32_t bench);

  /// Called before a client sends to a bench: if the bench has no room, runs its work, or waits
  /// briefly for another thread that does. @return whether the bench has room.
  bool make_room(std::uint32_t bench);

  struct Parts;  ///< private to the wire library

  [[nodiscard]] Parts& parts() noexcept { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::wire
