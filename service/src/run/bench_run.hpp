// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "base/event_record.hpp"
#include "clock/cycle_timer.hpp"
#include "clock/freerun_driver.hpp"
#include "clock/lockstep_driver.hpp"
#include "clock/realtime_driver.hpp"
#include "clock/shutdown.hpp"
#include "configuration/configuration.hpp"
#include "engine/bench_engine.hpp"
#include "engine/window_files.hpp"
#include "engine/window_pages.hpp"
#include "journal/journal.hpp"
#include "journal/journal_file.hpp"
#include "publish/reply_publisher.hpp"
#include "publish/report_publisher.hpp"
#include "publish/status_publisher.hpp"
#include "run/bench_wire.hpp"
#include "run/duplicate_number_detector.hpp"
#include "run/liveness.hpp"
#include "run/standstill.hpp"
#include "seam/doorbell.hpp"
#include "seam/queues.hpp"
#include "store/parameter_saver.hpp"
#include "store/parameter_store.hpp"
#include "vdrive/wire/local_bus.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::service {

/// Another service that started earlier has this bench number.
class BenchNumberTaken : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which threads run a bench in lock-step. In other clock modes it always has its own threads.
enum class LockstepThreads : std::uint8_t {
  own,      ///< a thread that steps and a thread that reports
  callers,  ///< none: clients call `BenchRun::work` in their threads
};

/// A running bench: the engine, its clock, its journal and stores, the encoding of its output, the
/// threads of all these, and a wire of any kind.
///
/// | thread    | work                                                              |
/// | --------- | ----------------------------------------------------------------- |
/// | tick      | only ticks; in lock-step: steps, replies and status               |
/// | status    | encodes status frames and samples of axes; not in lock-step       |
/// | reporter  | events, parameters, bench_state, the wire's health; replies,      |
/// |           | except in lock-step                                               |
/// | journal   | writes the journal, if there is one                               |
/// | saver     | saves parameters, if there is a store                             |
class BenchRun {
 public:
  using MakeWire =
      std::function<std::unique_ptr<BenchWire>(const Configuration& configuration, Counters&)>;

  /// Sets everything up, but does not announce the bench yet.
  /// @param configuration must have been checked
  /// @param journal takes the journal of this run; nullptr = no journal
  /// @param store the axes start with the parameters stored in it; nullptr = nothing can be stored
  /// @throws std::invalid_argument if the bank refuses an axis; wire::NetworkError
  BenchRun(Configuration configuration, JournalSink journal, std::unique_ptr<ParameterStore> store,
           const MakeWire& make_wire, LockstepThreads lockstep_threads = LockstepThreads::own);

  /// Stops as stop() does.
  ~BenchRun();
  BenchRun(const BenchRun&) = delete;
  BenchRun& operator=(const BenchRun&) = delete;

  /// Announces the bench and runs it.
  /// @throws BenchNumberTaken if an older service has the number; wire::NetworkError;
  ///         std::system_error if the journal cannot be written
  void start();

  /// For lock-step in the threads of callers: handles arrivals, lets time pass as far as the steps
  /// allow, and answers, unless another thread is doing so. That thread then also handles what has
  /// arrived in the meantime, up to a limit. Does nothing for a bench with its own threads. Any
  /// thread; never waits.
  wire::LocalWork work();

  /// @return whether clients may send, because half of the queue of arrivals is free. Any thread.
  [[nodiscard]] bool has_room() const noexcept { return inbox_.has_room(); }

  [[nodiscard]] bool has_run() const noexcept { return liveness_.has_begun(); }

  [[nodiscard]] bool is_alive() noexcept { return liveness_.has_advanced(); }

  /// @return whether the bench is announced: from its start until it begins to end. Any thread.
  [[nodiscard]] bool is_announced() const noexcept { return is_announced_; }

  /// @return the progress counters of the threads, once the bench is announced. Any thread.
  [[nodiscard]] const std::vector<Beats>& beats() const noexcept { return beats_; }

  /// Starts to refuse commands and to brake the axes, see Shutdown. Idempotent.
  void begin_shutdown() noexcept {
    is_announced_ = false;
    shutdown_.begin();
  }

  /// @return whether the axes have come to rest or cannot be braked: in lock-step no client steps
  ///         any more, so there is no drive time left to brake in.
  [[nodiscard]] bool is_shut_down() const noexcept { return lockstep_ || shutdown_.is_done(); }

  /// Makes `work` return at the next tick in all threads of callers; `stop` does the rest. Any
  /// thread.
  void begin_end() noexcept { stop_ = true; }

  /// Removes the power of all axes immediately, announces that the bench is offline and ends all
  /// threads. Idempotent.
  void stop() noexcept;

  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept {
    return duplicates_.conflict();
  }

  /// @return a description of the older service, see DuplicateNumberDetector.
  [[nodiscard]] std::string older_text() const { return duplicates_.older_text(); }

  [[nodiscard]] bool is_reachable() const noexcept { return counters_.wire_is_up.get() != 0; }

  [[nodiscard]] bool is_cut_off() const noexcept { return is_cut_off_; }

  [[nodiscard]] const Configuration& configuration() const noexcept { return configuration_; }

  [[nodiscard]] const BenchIdentity& identity() const noexcept { return identity_; }

  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

 private:
  /// Stored parameters: loaded before the axes are created, saved by a separate thread.
  struct StoredParameters {
    StoredParameters(std::unique_ptr<ParameterStore> store, Configuration& configuration);

    std::vector<EventRecord> news;  ///< to report once
    std::optional<std::filesystem::path> directory;
    std::optional<ParameterSaver> saver;
  };

  [[nodiscard]] bool works_in_callers() const noexcept {
    return configuration_.clock == ClockMode::lockstep &&
           lockstep_threads_ == LockstepThreads::callers;
  }

  void run();
  void finish_stores() noexcept;
  template <typename Function>
  void start_thread(Function function);
  void start_realtime();
  void start_freerun();
  template <typename Cycle>
  void start_ticking(int priority, Cycle cycle);
  void start_lockstep();
  void publish_status();
  void publish_waiting_status();
  void switch_off() noexcept;
  void report_once();
  void report();
  /// @return whether more notices may be left.
  bool receive_notices();
  void supervise_wire();
  void wait_for_status();

  // In the order of construction. Everything that the threads use outlives them.
  Configuration configuration_;
  LockstepThreads lockstep_threads_;
  StoredParameters parameters_;
  SystemCycleTimer timer_;
  BenchIdentity identity_;
  const std::string name_;  ///< for assertion messages
  Counters counters_;
  std::unique_ptr<BenchWire> wire_;
  ByteRing notices_;
  DuplicateNumberDetector duplicates_;
  Inbox inbox_;
  Outbox outbox_;
  std::optional<Journal> journal_;
  BenchEngine engine_;
  std::optional<WindowFiles> window_files_;
  WindowPages pages_;
  ReplyPublisher replies_;
  StatusPublisher status_;
  ReportPublisher reports_;
  std::optional<RealtimeDriver> realtime_;
  std::optional<LockstepDriver> lockstep_;
  std::optional<FreerunDriver> freerun_;
  Doorbell doorbell_;
  BellState reports_bell_;
  Doorbell reports_doorbell_;       ///< the tick thread rings it when there are reports or replies
  std::uint64_t lost_in_wire_ = 0;  ///< already counted as overflows
  std::uint64_t dropped_by_wire_ = 0;  ///< already counted as dropped datagrams
  Shutdown shutdown_{engine_, timer_};
  Counter tick_beats_;    ///< ticks; while paused, checks of the inbox
  Counter status_beats_;  ///< published images
  Counter report_beats_;  ///< rounds
  std::vector<Beats> beats_{
      {"ticks", &tick_beats_}, {"status", &status_beats_}, {"reports", &report_beats_}};
  Liveness liveness_{counts_of(beats_)};
  std::atomic<bool> is_announced_{false};
  std::atomic<bool> stop_{false};
  std::atomic<bool> is_cut_off_{false};
  bool is_running_ = false;
  std::mutex working_;  ///< held by the caller that runs the bench
  std::atomic<bool> is_work_wanted_{false};
  std::vector<std::thread> threads_;
};

}  // namespace vdrive::service
