// SPDX-License-Identifier: Apache-2.0
#include "support/bench_on_wire.hpp"

#include "client/session_options.hpp"
#include "support/process_tree.hpp"
#include "tool/process.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/wire/local_bus.hpp"

#include <cstdlib>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace vdrive::test {
namespace {

/// @return options for a bench in this process that match these arguments of vdrived.
bench::BenchOptions options_of(const std::string& words) {
  bench::BenchOptions options;
  std::string clock;  // a key of the configuration
  std::string mode;   // the mode that some keys need
  std::istringstream stream(words);
  std::string name;
  std::string value;
  while (stream >> name) {
    if (!(stream >> value)) throw std::runtime_error(name + ": a value is missing");
    if (name == "--clock") {
      options.clock = clock_mode_named(value);
      if (!options.clock) throw std::runtime_error("--clock " + value + ": no such clock");
      mode = "  mode: " + value + "\n";
    } else if (name == "--axes") {
      options.axes = std::stoul(value);
    } else if (name == "--bench") {
      options.number = static_cast<std::uint32_t>(std::stoul(value));
    } else if (name == "--period") {
      clock += "  period_us: " + value + "\n";
    } else if (name == "--rate") {
      clock += "  rate: " + value + "\n";
    } else if (name == "--steppers") {
      clock += "  steppers: " + value + "\n";
    } else if (name == "--config") {
      options.configuration = text_of(value);
    } else if (name == "--state") {
      options.state_directory = value;
    } else if (name == "--journal") {
      options.journal = value;
    } else {
      throw std::runtime_error(name + ": no option of a bench over both wires");
    }
  }
  if (!clock.empty()) options.configuration += "\nclock:\n" + mode + clock;
  // vdrived runs in real time by default, a bench in a process in lock-step.
  if (options.configuration.empty() && !options.clock) options.clock = ClockMode::realtime;
  return options;
}

}  // namespace

bool runs_over_dds() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no thread changes the environment
  const char* const wire = std::getenv("VDRIVE_TEST_WIRE");
  if (wire == nullptr || wire == std::string_view("local")) return false;
  if (wire == std::string_view("dds")) return true;
  throw std::runtime_error("VDRIVE_TEST_WIRE = " + std::string(wire) + ": must be local or dds");
}

std::shared_ptr<wire::LocalBus> local_bus() {
  if (runs_over_dds()) return nullptr;
  static const auto bus = std::make_shared<wire::LocalBus>();
  return bus;
}

client::SessionOptions options_on_wire() {
  if (runs_over_dds()) return options();
  client::SessionOptions options;
  options.bus = local_bus();
  return options;
}

/// The bench: in this process, or as a service.
class BenchOnWire::Parts {
 public:
  explicit Parts(const std::string& words) {
    if (runs_over_dds()) {
      service_.emplace(words);
    } else {
      bench::BenchOptions options = options_of(words);
      options.bus = local_bus();
      bench_.emplace(options);
    }
  }

 private:
  std::optional<RunningService> service_;
  std::optional<bench::Bench> bench_;
};

BenchOnWire::BenchOnWire(const std::string& words) : parts_(std::make_unique<Parts>(words)) {}

BenchOnWire::~BenchOnWire() = default;

}  // namespace vdrive::test
