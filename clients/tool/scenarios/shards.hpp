// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/scenario.hpp"
#include "output/junit.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Scenarios that several machines share, and the report of all of them.

/// @param text I/N, or /N where the number is that of the task of a job, in the environment:
///        JOB_COMPLETION_INDEX of Kubernetes, or SLURM_ARRAY_TASK_ID
/// @throws UsageError
[[nodiscard]] Shard parse_shard(const std::string& text);

/// Deals the files out in the order of their names, one that was named twice once: which shard has
/// which file depends on the names alone.
/// @param shard is told how many files there are
/// @return those of the shard.
[[nodiscard]] std::vector<Scenario> dealt_to(Shard& shard, std::vector<Scenario> scenarios);

/// What the reports of the shards of one run say together.
struct MergedReports {
  std::vector<JunitSuite> suites;     ///< in the order of their names, then what is missing
  std::vector<std::string> messages;  ///< of what failed, and of what is missing
  std::size_t shards = 0;             ///< that the run has
  std::vector<std::size_t> missing;   ///< numbers of those without a report
  std::size_t files = 0;              ///< that the run has, as far as it is known
  std::size_t passed = 0;
  ExitCode code = ExitCode::ok;  ///< failed before not_run
};

/// @param names of reports; a directory stands for every *.xml in it but for `output`
/// @return the files. @throws UsageError without any, and where a report is the output
[[nodiscard]] std::vector<std::string> report_files(const std::vector<std::string>& names,
                                                    const std::string& output);

/// @throws UsageError for reports that are not of one run.
[[nodiscard]] MergedReports merge_reports(const std::vector<std::string>& files);

}  // namespace vdrive::tool
