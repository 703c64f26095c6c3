// SPDX-License-Identifier: Apache-2.0
#include "wire/wire_process.hpp"

#include "base/log.hpp"
#include "seam/wire_region.hpp"
#include "vdrive/wire/end_announcement.hpp"
#include "vdrive/wire/library_log.hpp"
#include "wire/closed_check.hpp"
#include "wire/confinement.hpp"
#include "wire/library_log_sink.hpp"
#include "wire/wire_probe.hpp"
#include "wire/wire_program.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <string_view>
#include <thread>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kPumpInterval = 20ms;
constexpr auto kRetryInterval = 1ms;
/// The interval between rounds when status is late. It limits the rate to 1 GB/s, with which
/// readers keep up; faster sending overflows their socket buffers.
constexpr auto kBetweenRounds = 500us;
constexpr auto kProbeInterval = 500ms;
constexpr auto kWaitForReaders = 150ms;

/// If memory runs out, the kernel should kill the wire, because it can be restarted.
void raise_oom_score() {
  constexpr std::string_view kFirst = "500";  // as if it used another 50 % of the memory
  const int file = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);  // NOLINT(*-vararg)
  if (file >= 0) {
    if (write(file, kFirst.data(), kFirst.size()) < 0) {
      log_debug(
          "cannot raise oom_score_adj: when memory runs out, the kernel may not end the network "
          "process first");
    }
    close(file);
  }
}

/// Reads the memory of this process from a file that stays open, because none can be opened after
/// confine_wire().
class MemoryGauge {
 public:
  MemoryGauge() : file_(open("/proc/self/statm", O_RDONLY | O_CLOEXEC)) {}  // NOLINT(*-vararg)

  /// @return resident memory without the part shared with the engine [bytes].
  [[nodiscard]] std::uint64_t resident() const noexcept {
    std::array<char, 128> text{};
    const ssize_t size = pread(file_, text.data(), text.size(), 0);
    if (size <= 0) return 0;
    // size, resident, shared [pages]
    std::array<std::uint64_t, 3> pages{};
    const char* place = text.data();
    const char* const end = place + size;
    for (auto& count : pages) {
      while (place != end && *place == ' ') ++place;
      place = std::from_chars(place, end, count).ptr;
    }
    return (pages[1] - std::min(pages[1], pages[2])) *
           static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  }

 private:
  int file_;
};

/// Disables reloading of resolv.conf(5): after confine_wire() it cannot be opened, so a changed
/// list of name servers would be read as an empty one. Call it before there are threads.
void keep_name_servers() {
  constexpr const char* kOptions = "RES_OPTIONS";
  const char* const given = std::getenv(kOptions);  // NOLINT(concurrency-mt-unsafe)
  const std::string options = (given == nullptr ? "" : std::string(given) + " ") + "no-reload";
  setenv(kOptions, options.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
}

class WireProcess {
 public:
  explicit WireProcess(const WireRegion& region)
      : control_(region.control()),
        settings_(region.settings()),
        generation_(control_.generation.load()),
        dropped_before_(control_.datagrams_dropped.load()),
        program_(region, settings_),
        probe_(settings_.network, program_) {}

  /// Runs until the engine orders the end. @return the exit code.
  int run() {
    if (generation_ == 1 && !settings_.network.security.empty()) {
      check_closed(program_.participant(), settings_.network);
    }
    const MemoryGauge memory;
    confine_wire();
    std::thread status([this] {
      pump_status();
    });
    std::thread reports([this] {
      pump_reports();
    });
    std::thread prober([this] {
      probe();
    });
    control_.running_generation.store(generation_);
    control_.running_since.store(
        std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count());
    control_.state.store(WireState::running);
    while (control_.stop.load() == 0) {
      control_.resident.store(memory.resident());
      control_.datagrams_dropped.store(dropped_before_ + program_.datagrams_dropped());
      std::this_thread::sleep_for(100ms);
    }
    status.join();
    reports.join();
    announce_own_end();
    // No destructors: those of the library may hang, and all readers have the last message.
    _exit(0);
  }

 private:
  [[nodiscard]] bool goes_on() const noexcept { return control_.stop.load() == 0; }

  void pump_status() {
    Doorbell bell(control_.status_bell);
    bool has_more = false;
    while (goes_on() || has_more) {
      if (!has_more) bell.wait_for(kPumpInterval);
      const auto next = std::chrono::steady_clock::now() + kBetweenRounds;
      has_more = program_.drain(Lane::status) && goes_on();
      if (has_more) std::this_thread::sleep_until(next);
      status_rounds_.fetch_add(1, std::memory_order_relaxed);
      beat();
    }
  }

  /// Replies are sent first in every round, so that no answer waits for a burst of reports.
  void pump_reports() {
    Doorbell bell(control_.reports_bell);
    bool has_more = false;
    while (goes_on() || has_more) {
      if (!has_more) bell.wait_for(program_.is_holding() ? kRetryInterval : kPumpInterval);
      const bool has_replies = program_.drain(Lane::replies);
      has_more = program_.drain(Lane::reports) || has_replies;
      report_rounds_.fetch_add(1, std::memory_order_relaxed);
      beat();
    }
  }

  /// Publishes the number of rounds of the slower pump.
  void beat() noexcept {
    control_.pump_beats.store(std::min(status_rounds_.load(std::memory_order_relaxed),
                                       report_rounds_.load(std::memory_order_relaxed)));
  }

  void probe() {
    std::vector<std::string> troubles;
    while (goes_on()) {
      if (probe_.comes_through()) control_.probe_beats.fetch_add(1);
      log_troubles(troubles);
      std::this_thread::sleep_for(kProbeInterval);
    }
  }

  /// @param known the troubles that are already in the log; updated
  void log_troubles(std::vector<std::string>& known) {
    std::vector<std::string> troubles = program_.participant().troubles();
    for (const std::string& trouble : troubles) {
      if (std::ranges::count(known, trouble) == 0) {
        log_warning("network=trouble bench={} text=\"{}\"", settings_.bench, trouble);
      }
    }
    if (troubles.empty() && !known.empty()) {
      log_info(
          "network=good bench={} text=\"host names resolve and discovery servers answer again\"",
          settings_.bench);
    }
    known = std::move(troubles);
  }

  void announce_own_end() {
    static_cast<void>(program_.wait_for_readers(kWaitForReaders));
    wire::announce_end(settings_.network, control_.source);
    wire::announce_end(settings_.network, control_.prober);
    control_.finished.store(1);
  }

  WireControl& control_;
  WireSettings settings_;
  std::uint32_t generation_;
  std::uint64_t dropped_before_;  ///< datagrams dropped by earlier wires
  WireProgram program_;
  WireProbe probe_;
  std::atomic<std::uint64_t> status_rounds_{0};
  std::atomic<std::uint64_t> report_rounds_{0};
};

void report_error(WireControl& control, std::string_view error) {
  const std::string_view text = error.substr(0, control.error.size() - 1);
  std::ranges::copy(text, control.error.begin());
  control.error[text.size()] = '\0';
}

}  // namespace

int run_wire_process(int region_descriptor) {
  prctl(PR_SET_NAME, "vdrived-wire");  // NOLINT(*-vararg)
  raise_oom_score();
  keep_name_servers();
  const WireRegion region = WireRegion::attach(region_descriptor);
  WireControl& control = region.control();
  report_error(control, "");
  try {
    const WireSettings settings = region.settings();
    spdlog::set_default_logger(spdlog::stderr_color_mt("vdrived-wire"));
    is_program_of_vdrive() = true;
    spdlog::set_level(spdlog::level::from_str(settings.log_level));
    const wire::LibraryLog library_log(log_of_the_library(settings.bench));
    if (control.generation.load() > 1) {
      // The previous wire could not announce its end. Announce it now: until participants remove
      // it, their reliable writers wait for its readers, which no longer acknowledge anything.
      wire::announce_end(settings.network, control.source);
      wire::announce_end(settings.network, control.prober);
    }
    WireProcess process(region);
    return process.run();
  } catch (const std::exception& error) {
    report_error(control, error.what());
    if (control.generation.load() > 1) {  // for the first wire, the engine reports the reason
      log_error("wire=failed text=\"{}\"", error.what());
    }
    control.state.store(WireState::failed);
    return 1;
  }
}

}  // namespace vdrive::service
