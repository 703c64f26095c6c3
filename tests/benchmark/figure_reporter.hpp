// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <benchmark/benchmark.h>

#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::test {

/// Google Benchmark 1.7 of Debian 12 and 1.9 of Debian 13 have different members for a failure.
/// @return the reason for which the run failed, if it did.
template <typename Run>
std::optional<std::string> failure_of(const Run& run) {
  if constexpr (requires { run.error_occurred; }) {
    if (run.error_occurred) return run.error_message;
  } else {
    if (run.skipped != decltype(run.skipped){}) return run.skip_message;
  }
  return std::nullopt;
}

/// Prints one JSON line for each figure, with the medians.
class FigureReporter final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override {
    PrintBasicContext(&std::cerr, context);
    return true;
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (const auto failure = failure_of(run)) {
        std::cerr << run.benchmark_name() << ": " << *failure << '\n';
        failed_ = true;
      } else if (run.run_type == Run::RT_Aggregate && run.aggregate_name == "median") {
        print(run);
      }
    }
  }

  [[nodiscard]] bool failed() const { return failed_; }

 private:
  static void print(const Run& run) {
    const std::string& figure = run.run_name.function_name;
    std::cout << R"({"figure":")" << figure << '"';
    if (!run.run_name.args.empty()) std::cout << R"(,"axes":)" << run.run_name.args;
    std::cout << R"(,"value":)" << run.counters.at("value").value << "}\n" << std::flush;
  }

  bool failed_ = false;
};

}  // namespace vdrive::test
