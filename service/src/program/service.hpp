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

/// A bench on the network: a bench that runs, its metrics, and a wire, which names DDS and runs as
/// a process of its own or as threads of this one. Its receive thread, of the library, puts
/// arrivals into a ring.
class Service {
 public:
  /// Sets everything up; the bench is not announced yet.
  /// @param journal takes the journal of this run; nothing = none is written
  /// @param store what is stored in it is in force; nothing = nothing can be stored
  /// @param host of a wire's process; nothing = the wire is threads of this process
  /// @throws ConfigurationError, std::invalid_argument when the bank refuses an axis,
  ///         wire::NetworkError
  explicit Service(Configuration configuration, JournalSink journal = nullptr,
                   std::unique_ptr<ParameterStore> store = nullptr,
                   std::shared_ptr<WireHost> host = nullptr);

  /// Stops.
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// Receives for 300 ms, to detect a service with the same number, then announces the bench and
  /// runs it. With security material it first
  /// proves that strangers do not find it.
  /// @throws BenchNumberTaken when an older service has the number; wire::NetworkError when the
  ///         bench would be open in spite of its material; std::system_error when the journal
  ///         cannot be begun.
  void start();

  /// @return whether the first tick has run (in lock-step: whether steps are waited for) and its
  ///         status has left.
  [[nodiscard]] bool has_run() const noexcept;

  /// @return whether ticks (paused and in lock-step: the answers to requests), status and reports
  ///         have all gone on since the last call.
  [[nodiscard]] bool is_alive() noexcept;

  /// From here on commands are refused and the axes brake, see Shutdown. Idempotent.
  void begin_shutdown() noexcept;

  /// @return whether the axes have come to rest since `begin_shutdown`, or cannot: then `stop`.
  [[nodiscard]] bool is_shut_down() const noexcept;

  /// Takes the power from every axis at once, publishes that the bench is offline and ends every
  /// thread. Idempotent.
  void stop() noexcept;

  /// @return the incarnation of an older service with the same bench number that was met after the
  ///         start: this one has to go.
  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept;

  /// @return in a conflict, who that service is: "process 4711 on lab-pc (incarnation 17)".
  [[nodiscard]] std::string older_text() const;

  /// @return whether clients can reach the bench now: its wire runs.
  [[nodiscard]] bool is_reachable() const noexcept;

  /// @return whether no client can reach the bench any more in this run: no wire can be started.
  [[nodiscard]] bool is_cut_off() const noexcept;

  [[nodiscard]] const BenchIdentity& identity() const noexcept;
  [[nodiscard]] const Counters& counters() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::service
