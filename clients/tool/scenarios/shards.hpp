// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/scenario.hpp"
#include "output/junit.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Scenarios shared by several machines, and their common report.

/// @param text I/N, or /N to take the number from the environment of a job's task:
///        JOB_COMPLETION_INDEX of Kubernetes, or SLURM_ARRAY_TASK_ID
/// @throws UsageError
[[nodiscard]] Shard parse_shard(const std::string& text);

/// Deals out the files in the order of their names; duplicates count once. The names alone decide
/// which shard has which file.
/// @param shard receives the number of files
/// @return the files of the shard.
[[nodiscard]] std::vector<Scenario> dealt_to(Shard& shard, std::vector<Scenario> scenarios);

/// The combined reports of the shards of one run.
struct MergedReports {
  std::vector<JunitSuite> suites;     ///< in the order of their names, then missing ones
  std::vector<std::string> messages;  ///< about failed and missing parts
  std::size_t shards = 0;             ///< number in the run
  std::vector<std::size_t> missing;   ///< numbers of the shards without a report
  std::size_t files = 0;              ///< number in the run, as far as known
  std::size_t passed = 0;
  ExitCode code = ExitCode::ok;  ///< failed takes precedence over not_run
};

/// @param names of reports; a directory stands for every *.xml in it except `output`
/// @return the files. @throws UsageError if there is none, and if a report is the output
[[nodiscard]] std::vector<std::string> report_files(const std::vector<std::string>& names,
                                                    const std::string& output);

/// @throws UsageError for reports of different runs.
[[nodiscard]] MergedReports merge_reports(const std::vector<std::string>& files);

}  // namespace vdrive::tool
