// SPDX-License-Identifier: Apache-2.0
#include "scenarios/private_benches.hpp"

#include "base/service_program.hpp"
#include "base/usage_error.hpp"
#include "child_process.hpp"
#include "execution/connection.hpp"
#include "language/arguments.hpp"
#include "private_bench.hpp"
#include "vdrive/clock_mode.hpp"

#include <chrono>
#include <exception>
#include <stdexcept>

namespace vdrive::tool {
namespace {

using Wire = PrivateBenches::Wire;

// Long, because a bench over DDS has just been started and the machine may be busy.
constexpr std::chrono::seconds kFindTimeout{60};

constexpr const char* kDds = "dds";
constexpr const char* kLocal = "local";

bench::BenchOptions options_of_bench(const PrivateBenches& benches) {
  bench::BenchOptions options;
  options.configuration_file = benches.configuration;
  options.clock = ClockMode::lockstep;
  options.journal = benches.journal;
  return options;
}

std::vector<std::string> arguments_of_service(const PrivateBenches& benches) {
  std::vector<std::string> arguments{"--clock", "lockstep"};
  if (!benches.configuration.empty()) {
    arguments.insert(arguments.end(), {"--config", benches.configuration});
  }
  if (!benches.journal.empty()) {
    arguments.insert(arguments.end(), {"--journal", benches.journal});
  }
  return arguments;
}

/// A private bench is on this machine, and is found without a search.
void check_network(const PrivateBenches& benches, const GlobalOptions& options) {
  for (const std::string& name : options.network_given) {
    if (name != "--security") {
      throw UsageError(name +
                       " is for a running bench, which 'vdrive run FILE' uses; a private bench "
                       "takes no network options: leave it out");
    }
    if (benches.wire == Wire::local) {
      throw UsageError(name + " is for a bench over DDS: add --over dds");
    }
  }
}

void check_local(const PrivateBenches& benches) {
  if (!benches.service.empty()) {
    throw UsageError("--service is for a bench over DDS: add --over dds");
  }
  try {
    bench::check(options_of_bench(benches));
  } catch (const bench::NeedsNetwork& error) {
    throw UsageError("--config: " + std::string(error.what()) + ", as --over dds does");
  } catch (const bench::BenchError& error) {
    throw UsageError("--config: " + std::string(error.what()));
  }
}

void check_over_dds(const PrivateBenches& benches) {
  const std::string service = find_service(benches.service);
  if (benches.configuration.empty()) return;
  process::ChildProcess check({service, "--check", benches.configuration});
  if (check.wait() == 0) return;
  std::string text = check.errors();
  while (text.ends_with('\n')) text.pop_back();
  throw UsageError("--config: " + text);
}

}  // namespace

void PrivateBenches::declare(Arguments& arguments) {
  std::string& over = arguments.text();
  arguments
      .option("--over", "WIRE", over,
              "local: the bench is in the process that runs the file (default); dds: it is a "
              "vdrived on a domain that no other program uses")
      .one_of({kLocal, kDds});
  arguments.then([this, &over] {
    if (over == kDds) wire = Wire::dds;
    names_wire = !over.empty();
  });
  arguments.option("--config", "FILE", configuration,
                   "Configuration of the benches; default: the demo bench");
  arguments.option(
      "--service", "FILE", service,
      "With --over dds: the program vdrived; default: next to this program, otherwise from PATH");
}

void PrivateBenches::declare_journal(Arguments& arguments) {
  arguments.option(
      "--journal", "FILE", journal,
      "Write a journal of the bench, which 'vdrive judge' and 'vdrived --replay' read");
}

void PrivateBenches::check(const GlobalOptions& options) const {
  check_network(*this, options);
  if (wire == Wire::local) {
    check_local(*this);
  } else {
    check_over_dds(*this);
  }
}

std::vector<std::string> PrivateBenches::arguments() const {
  std::vector<std::string> words;
  if (names_wire) words.insert(words.end(), {"--over", wire == Wire::dds ? kDds : kLocal});
  if (!configuration.empty()) words.insert(words.end(), {"--config", configuration});
  if (!service.empty()) words.insert(words.end(), {"--service", service});
  if (!journal.empty()) words.insert(words.end(), {"--journal", journal});
  return words;
}

PrivateSession::PrivateSession(const PrivateBenches& benches, const GlobalOptions& options,
                               Interrupt& interrupt)
    : interrupt_(interrupt) {
  try {
    open(benches, options);
  } catch (const UsageError&) {
    throw;
  } catch (const std::exception& error) {
    throw NotRun(error.what());
  }
  interrupt_.arm([this] {
    session_->interrupt();
  });
}

PrivateSession::~PrivateSession() {
  interrupt_.disarm();
}

void PrivateSession::open(const PrivateBenches& benches, const GlobalOptions& options) {
  if (benches.wire == Wire::local) {
    open_local(benches, session_options(options));
    return;
  }
  GlobalOptions patient = options;
  if (!patient.timeout) patient.timeout = kFindTimeout;
  open_over_dds(benches, session_options(patient));
}

void PrivateSession::open_local(const PrivateBenches& benches, client::SessionOptions options) {
  bench_.emplace(options_of_bench(benches));
  options.bus = bench_->bus();
  session_.emplace(options);
}

void PrivateSession::open_over_dds(const PrivateBenches& benches, client::SessionOptions options) {
  service_ = std::make_unique<process::PrivateBench>(find_service(benches.service),
                                                     arguments_of_service(benches));
  interrupt_.arm([this] {
    service_->end();
  });
  const auto problem = service_->wait_until_ready();
  interrupt_.disarm();
  // After an interrupt the session itself finds nothing, and reports why.
  if (problem && !interrupt_.happened()) throw std::runtime_error(*problem);
  options.domain = service_->domain();
  session_.emplace(options);
}

}  // namespace vdrive::tool
