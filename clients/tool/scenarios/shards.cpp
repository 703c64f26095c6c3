// SPDX-License-Identifier: Apache-2.0
#include "scenarios/shards.hpp"

#include "base/usage_error.hpp"
#include "values/value.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr const char* kIndex = "JOB_COMPLETION_INDEX";
constexpr const char* kTask = "SLURM_ARRAY_TASK_ID";
constexpr const char* kFirstTask = "SLURM_ARRAY_TASK_MIN";
constexpr const char* kTasks = "SLURM_ARRAY_TASK_COUNT";

std::string shown_name(const std::string& file) {
  return escaped(file, kShownOfMessage);
}

/// @return the number in an environment variable, if it is set.
std::optional<std::uint64_t> number_in(const char* variable) {
  const char* const text = std::getenv(variable);  // NOLINT(*-mt-unsafe): nothing sets variables
  if (text == nullptr) return std::nullopt;
  return parse_number(text, variable, std::numeric_limits<std::uint32_t>::max());
}

/// @return the index, from 0, of a task in a Slurm array, whose numbers the user chooses.
std::uint64_t index_in_array(std::uint64_t task, std::size_t count) {
  const auto first = number_in(kFirstTask);
  const auto tasks = number_in(kTasks);
  if (!first || !tasks) {
    throw UsageError(std::string("--shard: ") + kTask + " is set without " + kFirstTask + " and " +
                     kTasks + ": write I/N");
  }
  // If a part of the array was submitted again, its task numbers no longer match its size.
  if (*tasks != count || task < *first) {
    throw UsageError("--shard /" + std::to_string(count) + ": the array has " +
                     counted(*tasks, "task", "tasks") + " from " + std::to_string(*first) +
                     " on (" + kTasks + "), task " + std::to_string(task) +
                     ": write I/N if only a part of the array runs");
  }
  return task - *first;
}

/// @return the number of the shard, from 1, as given by the job.
std::size_t number_of_task(std::size_t count) {
  const auto index = number_in(kIndex);
  const auto task = number_in(kTask);
  if (index && task) {
    throw UsageError(std::string("--shard: both ") + kIndex + " and " + kTask +
                     " are set: write I/N");
  }
  if (!index && !task) {
    throw UsageError("--shard /" + std::to_string(count) + ": neither " + kIndex + " nor " + kTask +
                     " is set: write I/N, such as 1/" + std::to_string(count));
  }
  const std::uint64_t from_zero = index ? *index : index_in_array(*task, count);
  if (from_zero >= count) {
    throw UsageError("--shard /" + std::to_string(count) + ": " + (index ? kIndex : kTask) +
                     " is " + std::to_string(index ? *index : *task) + ", task " +
                     std::to_string(from_zero + 1) + " of " + std::to_string(count));
  }
  return from_zero + 1;
}

constexpr std::size_t kNoNumber = std::numeric_limits<std::size_t>::max();

/// @return kNoNumber for anything but 0 to Shard::kMost.
std::size_t number_of(std::string_view text) {
  const auto number = parse_integer(text);
  if (!number || *number < 0 || static_cast<std::uint64_t>(*number) > Shard::kMost) {
    return kNoNumber;
  }
  return static_cast<std::size_t>(*number);
}

/// @return the text of a file. @throws UsageError without the file name
std::string content_of(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw UsageError("is not a file");
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw UsageError("cannot be read: " + std::generic_category().message(errno));
  return text;
}

bool is_same_file(const std::string& one, const std::string& other) {
  std::error_code error;  // set if one of them does not exist yet
  return std::filesystem::equivalent(one, other, error);
}

std::vector<std::string> reports_in(const std::string& directory, const std::string& output) {
  std::vector<std::string> files;
  std::error_code error;
  for (std::filesystem::directory_iterator at(directory, error), end; !error && at != end;
       at.increment(error)) {
    const std::string file = at->path().string();
    if (at->path().extension() == ".xml" && !is_same_file(file, output)) files.push_back(file);
  }
  if (error) {
    throw UsageError("cannot read the directory " + in_quotes(directory) + ": " + error.message());
  }
  if (files.empty()) {
    throw UsageError("the directory " + in_quotes(directory) + " has no report, *.xml");
  }
  std::ranges::sort(files);
  return files;
}

bool is_verdict(const JunitCase& test) {
  return (test.failure || test.error) && test.type != JunitCase::kNotRun &&
         test.type != JunitCase::kInterrupted;
}

/// @return failed; not_run if a part of it was not judged; or ok.
ExitCode verdict_of_suite(const JunitSuite& suite) {
  if (std::ranges::any_of(suite.cases, is_verdict)) return ExitCode::failed;
  const bool is_whole = std::ranges::none_of(suite.cases, [](const JunitCase& test) {
    return test.failure || test.error || test.is_skipped;
  });
  return is_whole ? ExitCode::ok : ExitCode::not_run;
}

std::string name_of_shard(const Shard& shard) {
  return "shard " + std::to_string(shard.number) + " of " + std::to_string(shard.count);
}

JunitSuite missing_suite(const std::string& name, const std::string& message) {
  return {.name = name,
          .cases = {{.name = "report", .error = message, .type = JunitCase::kNotRun}}};
}

/// Reads the reports and checks that they belong together.
class Merge {
 public:
  void add(const std::string& file) {
    JunitContent content;
    try {
      content = read_junit(content_of(file));
    } catch (const UsageError& error) {
      merged_.messages.push_back(shown_name(file) + ": " + error.what());
      unread_.push_back(missing_suite(file, error.what()));
      return;
    }
    if (!content.shard) {
      mistakes_.note(shown_name(file) +
                     ": does not belong to a shard: it was written without --shard");
      return;
    }
    if (fits(file, *content.shard)) add_suites(*content.shard, std::move(content.suites));
  }

  MergedReports conclude() {
    mistakes_.throw_if_any();
    std::ranges::stable_sort(merged_.suites, {}, &JunitSuite::name);
    merged_.shards = first_ ? first_->shard.count : 0;
    merged_.files = std::max(files_, merged_.suites.size());
    for (const JunitSuite& suite : merged_.suites) judge(suite);
    name_missing();
    if (merged_.code == ExitCode::ok && !unread_.empty()) merged_.code = ExitCode::not_run;
    std::ranges::move(unread_, std::back_inserter(merged_.suites));
    return std::move(merged_);
  }

 private:
  struct Report {
    std::string file;
    Shard shard;
  };

  /// @return whether the report belongs to the same run as the previous ones.
  bool fits(const std::string& file, const Shard& shard) {
    if (!first_) first_ = Report{file, shard};
    if (shard.count != first_->shard.count) {
      mistakes_.note(shown_name(file) + ": belongs to " + name_of_shard(shard) + ", " +
                     shown_name(first_->file) + " to " + name_of_shard(first_->shard) +
                     ": they are from different runs");
      return false;
    }
    const auto [former, is_new] = reports_.emplace(shard.number, file);
    if (!is_new) {
      mistakes_.note(shown_name(file) + ": belongs to " + name_of_shard(shard) + ", as does " +
                     shown_name(former->second));
      return false;
    }
    if (shard.files == 0) return true;  // it failed before it knew the number
    if (files_ == 0) files_ = shard.files;
    if (files_ == shard.files) return true;
    mistakes_.note(shown_name(file) + ": " + name_of_shard(shard) + " is of " +
                   std::to_string(shard.files) + " files, others of " + std::to_string(files_) +
                   ": they are from different runs");
    return false;
  }

  void add_suites(const Shard& shard, std::vector<JunitSuite> suites) {
    for (JunitSuite& suite : suites) {
      if (shard.files != 0) {
        const auto [former, is_new] = shard_of_.emplace(suite.name, shard.number);
        if (!is_new) {
          mistakes_.note(shown_name(suite.name) + ": is in the reports of shard " +
                         std::to_string(former->second) + " and shard " +
                         std::to_string(shard.number) + ": the shards were given different files");
        }
      }
      merged_.suites.push_back(std::move(suite));
    }
  }

  void judge(const JunitSuite& suite) {
    const ExitCode code = verdict_of_suite(suite);
    if (code == ExitCode::ok) {
      ++merged_.passed;
      return;
    }
    if (merged_.code != ExitCode::failed) merged_.code = code;
    const bool is_told = std::ranges::any_of(suite.cases, [](const JunitCase& test) {
      return test.failure || test.error;
    });
    if (!is_told) merged_.messages.push_back(shown_name(suite.name) + ": was not run");
    for (const JunitCase& test : suite.cases) {
      if (!test.failure && !test.error) continue;
      const std::string& message = test.failure ? *test.failure : *test.error;
      merged_.messages.push_back(test.text.empty() ? shown_name(suite.name) + ": " + message
                                                   : test.text);
    }
  }

  void name_missing() {
    std::string numbers;
    for (std::size_t number = 1; number <= merged_.shards; ++number) {
      if (reports_.contains(number)) continue;
      merged_.missing.push_back(number);
      numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
      unread_.push_back(missing_suite(
          name_of_shard(Shard{.number = number, .count = merged_.shards}), "has no report"));
    }
    if (merged_.missing.empty()) return;
    merged_.messages.push_back("no report of shard " + numbers + " of " +
                               std::to_string(merged_.shards));
  }

  MergedReports merged_;
  Mistakes mistakes_;
  std::vector<JunitSuite> unread_;  ///< for unreadable files and missing shards
  std::optional<Report> first_;
  std::map<std::size_t, std::string> reports_;   ///< file names, by the number of the shard
  std::map<std::string, std::size_t> shard_of_;  ///< shard numbers, by the name of the scenario
  std::size_t files_ = 0;                        ///< of all shards; 0 = unknown
};

}  // namespace

Shard parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const std::size_t count =
      slash == std::string::npos ? kNoNumber : number_of(text.substr(slash + 1));
  const bool is_of_task = slash == 0;
  const std::size_t number = is_of_task ? 1 : number_of(text.substr(0, slash));
  if (count == 0 || count == kNoNumber || number == kNoNumber) {
    throw UsageError("--shard: " + in_quotes(text) +
                     " is not I/N, such as 2/7, or /7 to take I from the job; N is from 1 to " +
                     std::to_string(Shard::kMost));
  }
  if (number == 0 || number > count) {
    throw UsageError("--shard: " + in_quotes(text) + ": the shards are 1 to " +
                     std::to_string(count));
  }
  return {.number = is_of_task ? number_of_task(count) : number, .count = count};
}

std::vector<Scenario> dealt_to(Shard& shard, std::vector<Scenario> scenarios) {
  std::ranges::sort(scenarios, {}, &Scenario::file);
  // The compiler of Debian 12 does not have std::ranges::unique.
  const auto doubles = std::unique(scenarios.begin(), scenarios.end(),
                                   [](const Scenario& one, const Scenario& other) {
                                     return one.file == other.file;
                                   });
  scenarios.erase(doubles, scenarios.end());
  shard.files = scenarios.size();
  std::vector<Scenario> dealt;
  for (std::size_t i = shard.number - 1; i < scenarios.size(); i += shard.count) {
    dealt.push_back(std::move(scenarios[i]));
  }
  return dealt;
}

std::vector<std::string> report_files(const std::vector<std::string>& names,
                                      const std::string& output) {
  std::vector<std::string> files;
  for (const std::string& name : names) {
    std::error_code error;
    const auto status = std::filesystem::status(name, error);
    if (!std::filesystem::exists(status)) {
      throw UsageError("--merge: no report " + in_quotes(name) + ": " + error.message());
    }
    if (std::filesystem::is_directory(status)) {
      std::ranges::move(reports_in(name, output), std::back_inserter(files));
    } else if (is_same_file(name, output)) {
      throw UsageError("--junit: " + in_quotes(output) + " is one of the reports to merge");
    } else {
      files.push_back(name);
    }
  }
  return files;
}

MergedReports merge_reports(const std::vector<std::string>& files) {
  Merge merge;
  for (const std::string& file : files) merge.add(file);
  return merge.conclude();
}

}  // namespace vdrive::tool
