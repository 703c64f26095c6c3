// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "journal/journal_file.hpp"
#include "run/bench_run.hpp"
#include "store/parameter_store.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::service {

struct WireHost;

/// A bench on the network: a running bench, its metrics, and its wire, which runs DDS in a separate
/// process or in threads of this one. A receive thread of the DDS library puts arrivals into a
/// ring.
class Service {
 public:
  /// Sets everything up, but does not announce the bench yet.
  /// @param journal takes the journal of this run; nullptr = no journal
  /// @param store the axes start with the parameters stored in it; nullptr = nothing can be stored
  /// @param host of the wire's process; nullptr = the wire runs in threads of this process
  /// @throws ConfigurationError; std::invalid_argument if the bank refuses an axis;
  ///         wire::NetworkError
  explicit Service(Configuration configuration, JournalSink journal = nullptr,
                   std::unique_ptr<ParameterStore> store = nullptr,
                   std::shared_ptr<WireHost> host = nullptr);

  /// Stops as stop() does.
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// Listens for 300 ms to detect a service with the same bench number, then announces the bench
  /// and runs it. In the closed mode it first proves that strangers cannot discover the bench.
  /// @throws BenchNumberTaken if an older service has the number; wire::NetworkError if the bench
  ///         would be open in spite of its credentials; std::system_error if the journal cannot be
  ///         written
  void start();

  /// @return whether the first tick has run (in lock-step: whether the bench waits for steps) and
  ///         its status has been sent.
  [[nodiscard]] bool has_run() const noexcept;

  /// @return whether ticks, status and reports have all made progress since the last call. While
  ///         paused and in lock-step, answers to requests count instead of ticks.
  [[nodiscard]] bool is_alive() noexcept;

  /// Starts to refuse commands and to brake the axes, see Shutdown. Idempotent.
  void begin_shutdown() noexcept;

  /// @return whether, after `begin_shutdown`, the axes have come to rest or cannot be braked: then
  ///         call `stop`.
  [[nodiscard]] bool is_shut_down() const noexcept;

  /// Removes the power of all axes immediately, announces that the bench is offline and ends all
  /// threads. Idempotent.
  void stop() noexcept;

  /// @return the incarnation of an older service with the same bench number that was found after
  ///         the start: then this service has to end.
  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept;

  /// @return in a conflict, a description of the older service, such as "process 4711 on lab-pc
  ///         (incarnation 17)".
  [[nodiscard]] std::string older_text() const;

  /// @return whether clients can reach the bench now, because its wire runs.
  [[nodiscard]] bool is_reachable() const noexcept;

  /// @return whether clients cannot reach the bench again in this run, because no wire can be
  ///         started.
  [[nodiscard]] bool is_cut_off() const noexcept;

  [[nodiscard]] const BenchIdentity& identity() const noexcept;
  [[nodiscard]] const Counters& counters() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::service
