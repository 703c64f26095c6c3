// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <benchmark/benchmark.h>

#include <iostream>
#include <string>
#include <vector>

namespace vdrive::test {

/// One JSON line for each figure, of the medians.
class FigureReporter final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override {
    PrintBasicContext(&std::cerr, context);
    return true;
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred) {
        std::cerr << run.benchmark_name() << ": " << run.error_message << '\n';
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
