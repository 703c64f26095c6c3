// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/checks.hpp"
#include "vdrive/text.hpp"

#include <chrono>
#include <string>

namespace vdrive::tool {
namespace {

Finding check_version(const client::BenchInfo& bench) {
  Finding finding{.subject = "benches",
                  .text = "bench " + std::to_string(bench.number) + " " + in_quotes(bench.name) +
                          ", " + std::to_string(bench.axes.size()) + " axes, " +
                          std::string(to_string(bench.clock_mode)) + ", version " +
                          bench.service_version +
                          (bench.host.empty() ? "" : ", on " + escaped(bench.host)),
                  .advice = ""};
  if (bench.service_version != VDRIVE_VERSION) {
    finding.severity = Severity::hint;
    finding.advice = "this tool is version " VDRIVE_VERSION ": update the older one";
  }
  return finding;
}

Finding check_wire(const client::BenchInfo& bench) {
  const std::string subject = "the network process of bench " + std::to_string(bench.number);
  if (bench.wire_starts == 1) {
    return {.subject = "benches",
            .text = subject + " has not ended since the service started",
            .advice = ""};
  }
  const std::uint64_t restarts = bench.wire_starts - 1;
  return {.severity = Severity::hint,
          .subject = "benches",
          .text = subject + " was started again " +
                  (restarts == 1 ? "once" : std::to_string(restarts) + " times") +
                  " since the service started; the axes did not stop",
          .advice =
              "the log of the service and the events of the bench give the reason of each restart"};
}

/// Half of the default of watchdog.timeout_ms (docs/guides/configuration.md).
constexpr std::chrono::milliseconds kLongSilence{250};

Finding check_silence(const client::BenchInfo& bench) {
  const auto silence = std::chrono::floor<std::chrono::milliseconds>(bench.longest_silence);
  Finding finding{.subject = "benches",
                  .text = "the longest time in which bench " + std::to_string(bench.number) +
                          " received nothing from an owner of axes is " +
                          std::to_string(silence.count()) + " ms of drive time",
                  .advice = ""};
  if (silence >= kLongSilence) {
    finding.severity = Severity::hint;
    finding.advice =
        "the machine or the network is busy: keep watchdog.timeout_ms above twice this time, or "
        "use lock-step";
  }
  return finding;
}

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::good:
      return "good";
    case Severity::hint:
      return "hint";
    case Severity::problem:
      return "problem";
  }
  return "unknown";
}

}  // namespace

std::vector<Finding> check_troubles(std::span<const std::string> troubles) {
  std::vector<Finding> findings;
  for (const std::string& trouble : troubles) {
    findings.push_back(
        {.severity = Severity::problem,
         .subject = "network",
         .text = trouble,
         .advice = "check --peer and --discovery-server, that the hosts that they name run, and "
                   "that this machine's name server knows them"});
  }
  return findings;
}

std::vector<Finding> check_benches(std::span<const client::BenchInfo> benches,
                                   const GlobalOptions& options) {
  if (benches.empty()) {
    return {{.severity = Severity::hint,
             .subject = "benches",
             .text = "none on domain " + std::to_string(options.domain),
             .advice = "start one with 'vdrived', or name its domain and network with --domain, "
                       "--interface, --peer or --discovery-server"}};
  }
  std::vector<Finding> findings;
  for (const client::BenchInfo& bench : benches) {
    findings.push_back(check_version(bench));
    // 0 = not received yet.
    if (bench.wire_starts != 0) {
      findings.back().figures = bench.figures;
      findings.push_back(check_wire(bench));
      findings.push_back(check_silence(bench));
    }
  }
  return findings;
}

Record finding_record(const Finding& finding) {
  const char* const severity = name_of(finding.severity);
  Record record{{"severity", severity, severity},
                {"subject", finding.subject, finding.subject + ":"},
                {"text", finding.text, finding.text}};
  if (!finding.advice.empty()) record.push_back({"advice", finding.advice});
  Json figures;
  for (const client::Figure& figure : finding.figures) {
    figures[std::string(figure.name)] = figure.value;
  }
  if (!figures.empty()) record.push_back({"figures", std::move(figures)});
  return record;
}

}  // namespace vdrive::tool
