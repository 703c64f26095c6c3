// SPDX-License-Identifier: Apache-2.0
#include "vdrive/bench/bench.hpp"

#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "configuration/configuration_file.hpp"
#include "configuration/presets.hpp"
#include "journal/journal_file.hpp"
#include "run/bench_run.hpp"
#include "run/bench_wire.hpp"
#include "seam/wire_link.hpp"
#include "seam/wire_region.hpp"
#include "settings/configuration_error.hpp"
#include "store/parameter_store.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/local_bus.hpp"
#include "vdrive/wire/origin.hpp"
#include "vdrive/wire/participant.hpp"
#include "wire/wire_program.hpp"

#include <chrono>
#include <cstddef>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bench {
namespace {

using service::Configuration;

static_assert(kMostAxes == service::kMaxAxes);
static_assert(kHighestNumber == wire::kHighestBench);

constexpr const char* kTextOfOptions = "configuration";

Configuration read(const BenchOptions& options) {
  if (!options.configuration.empty() && !options.configuration_file.empty()) {
    throw BenchError("configuration and configuration_file are both given: give only one");
  }
  if (!options.configuration_file.empty()) {
    return service::load_configuration(options.configuration_file);
  }
  if (!options.configuration.empty()) {
    return service::parse_configuration(options.configuration, kTextOfOptions);
  }
  Configuration configuration = service::demo_configuration();
  configuration.clock = ClockMode::lockstep;
  return configuration;
}

/// A bench in a process has no network: a network setting is an error, not silently ignored.
/// @param where start of the message: the file, or nothing
void refuse_network(const Configuration& configuration, const std::string& where) {
  const wire::NetworkSettings defaults;
  const wire::NetworkSettings& network = configuration.network;
  const auto refuse = [&where](const std::string& key) {
    throw NeedsNetwork(where + key +
                       " is a network setting, which a bench in this process does not support: "
                       "remove it, or start vdrived");
  };
  if (configuration.metrics_port) refuse("metrics.port");
  if (configuration.wire_form) refuse("wire.form");
  if (configuration.wire_memory_limit_mib != Configuration().wire_memory_limit_mib) {
    refuse("wire.memory_limit_mib");
  }
  if (!network.interfaces.empty()) refuse("network.interfaces");
  if (!network.peers.empty()) refuse("network.peers");
  if (!network.discovery_servers.empty()) refuse("network.discovery_server");
  if (network.shared_memory != defaults.shared_memory) refuse("network.shared_memory");
  if (!network.security.empty()) refuse("network.security");
  if (network.domain != defaults.domain) refuse("network.domain");
}

/// @throws BenchError if two options specify the axes
void refuse_two_kinds_of_axes(const BenchOptions& options) {
  if (options.axis_configurations.empty()) return;
  if (options.axes || !options.preset.empty()) {
    throw BenchError(std::string("axis_configurations and ") + (options.axes ? "axes" : "preset") +
                     " are both given: give only one");
  }
}

std::vector<service::NamedAxis> axes_of(const std::vector<AxisConfiguration>& configurations) {
  std::vector<service::NamedAxis> axes = service::default_axes(configurations.size());
  for (std::size_t index = 0; index < axes.size(); ++index) {
    axes[index].configuration = configurations[index];
  }
  return axes;
}

/// Checks axes that do not come from a file: the bank has rules that involve several values.
/// @throws BenchError
void try_axes(const Configuration& configuration) {
  for (const service::NamedAxis& axis : configuration.axes) {
    try {
      const AxisBank bank(std::span(&axis.configuration, 1), configuration.period);
    } catch (const std::invalid_argument& refusal) {
      throw BenchError("axis " + std::to_string(axis.number) + ": " + refusal.what());
    }
  }
}

Configuration configuration_of(const BenchOptions& options) {
  refuse_two_kinds_of_axes(options);
  Configuration configuration = read(options);
  const std::string file = options.configuration_file.string();
  refuse_network(configuration, file.empty() ? "" : escaped(file) + ": ");
  if (!options.axis_configurations.empty()) {
    configuration.axes = axes_of(options.axis_configurations);
  } else if (!options.preset.empty()) {
    configuration.axes = service::preset_axes(options.preset, options.axes.value_or(1));
  } else if (options.axes) {
    configuration.axes = service::default_axes(*options.axes);
  }
  if (options.clock && !clock_mode_named(to_string(*options.clock))) {
    throw BenchError("clock = " + std::to_string(static_cast<int>(*options.clock)) +
                     ": not a clock mode");
  }
  if (options.clock) configuration.clock = *options.clock;
  if (options.period) configuration.period = *options.period;
  if (options.number) configuration.bench = *options.number;
  configuration.network.bus = options.bus ? options.bus : std::make_shared<wire::LocalBus>();
  service::check(configuration);
  if (options.period || !options.axis_configurations.empty()) try_axes(configuration);
  return configuration;
}

/// @throws BenchError in place of any other exception
template <typename Function>
auto with_bench_errors(Function function) {
  try {
    return function();
  } catch (const BenchError&) {
    throw;
  } catch (const std::exception& error) {
    throw BenchError(error.what());
  }
}

std::unique_ptr<service::ParameterStore> store_of(const BenchOptions& options,
                                                  const Configuration& configuration) {
  if (options.state_directory.empty()) return nullptr;
  return service::open_parameter_store(options.state_directory.string(), configuration.bench);
}

service::JournalSink journal_of(const BenchOptions& options) {
  return options.journal.empty() ? nullptr : service::open_journal(options.journal.string());
}

/// A wire without a network: output of the engine goes to the local bus on the thread that writes
/// it, and input arrives on the thread of the session that sends it.
class LocalWire final : public service::BenchWire {
 public:
  /// @param configuration its network settings name the bus
  /// @throws wire::NetworkError when another bench on the bus has the number
  LocalWire(const Configuration& configuration, service::Counters& counters)
      : region_(service::wire_settings(configuration), service::WireRegion::Sharing::none),
        link_(region_),
        program_(region_, service::wire_settings(configuration)),
        counters_(counters) {
    link_.send_through(program_);
    counters.wire_starts.add();
  }

  [[nodiscard]] const service::WireRegion& region() const noexcept override { return region_; }

  [[nodiscard]] service::WireLink& link() noexcept override { return link_; }

  void start() override {
    link_.begin();
    counters_.wire_is_up.set(1);
  }

  /// None: the bus already knows whether a number is taken.
  [[nodiscard]] std::chrono::milliseconds duplicate_detection_time() const noexcept override {
    return std::chrono::milliseconds{0};
  }

  void stop(std::chrono::milliseconds /*patience*/) override { link_.end(); }

 private:
  service::WireRegion region_;
  service::WireLink link_;
  service::WireProgram program_;
  service::Counters& counters_;
};

}  // namespace

/// `work_` is the last member, so that it is destroyed first: no thread works for a bench that has
/// ended.
class Bench::Parts {
 public:
  Parts(Configuration configuration, service::JournalSink journal,
        std::unique_ptr<service::ParameterStore> store)
      : bus_(configuration.network.bus),
        run_(
            std::move(configuration), std::move(journal), std::move(store),
            [](const Configuration& chosen, service::Counters& counters) {
              return std::make_unique<LocalWire>(chosen, counters);
            },
            service::LockstepThreads::callers) {
    run_.start();
    work_.emplace(bus_, number(),
                  wire::LocalBus::Work{.run =
                                           [this] {
                                             return run_.work();
                                           },
                                       .has_room =
                                           [this] {
                                             return run_.has_room();
                                           }});
    bus_->run_work(number());  // for sessions that have already found the bench
  }

  ~Parts() {
    run_.begin_end();  // first, so that a step in progress does not delay the end
    work_.reset();
  }

  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  [[nodiscard]] const wire::Origin& origin() const noexcept { return origin_; }

  [[nodiscard]] const std::shared_ptr<wire::LocalBus>& bus() const noexcept { return bus_; }

  [[nodiscard]] std::uint32_t number() const noexcept { return run_.identity().bench; }

 private:
  const wire::Origin origin_;
  std::shared_ptr<wire::LocalBus> bus_;
  service::BenchRun run_;
  std::optional<wire::LocalBus::WorkPlace> work_;
};

std::vector<std::string> preset_names() {
  return service::preset_names();
}

void check(const BenchOptions& options) {
  static_cast<void>(with_bench_errors([&] {
    return configuration_of(options);
  }));
}

Bench::Bench(const BenchOptions& options)
    : parts_(with_bench_errors([&] {
        Configuration configuration = configuration_of(options);
        const std::string number = std::to_string(configuration.bench);
        auto store = store_of(options, configuration);
        try {
          return std::unique_ptr<Parts, End>(
              new Parts(std::move(configuration), journal_of(options), std::move(store)));
        } catch (const wire::NameTaken&) {
          throw BenchError("number = " + number + ": bench " + number +
                           " is already on this bus: give each bench a different number");
        }
      })) {}

void Bench::End::operator()(Parts* parts) const noexcept {
  // NOLINTNEXTLINE(*-owning-memory): a deleter
  if (!parts->origin().is_inherited()) delete parts;
}

void Bench::require_own_process() const {
  if (parts_->origin().is_inherited()) throw BenchError(parts_->origin().problem("the bench"));
}

Bench::~Bench() = default;
Bench::Bench(Bench&& other) noexcept = default;
Bench& Bench::operator=(Bench&& other) noexcept = default;

std::shared_ptr<wire::LocalBus> Bench::bus() const {
  require_own_process();
  return parts_->bus();
}

client::Session Bench::session(client::SessionOptions options) const {
  require_own_process();
  options.bus = parts_->bus();
  return client::Session(options);
}

std::uint32_t Bench::number() const noexcept {
  return parts_->number();
}

}  // namespace vdrive::bench
