// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/signals.hpp"
#include "support/test_domain.hpp"

#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::test {

/// A vdrived running on the domain of this test; the destructor ends it.
class ServiceProcess {
 public:
  ServiceProcess(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {program, "--log-level", "error", "--domain", std::to_string(test_domain())});
    process_ = fork();
    if (process_ == 0) {
      std::vector<char*> values;
      for (auto& argument : arguments) values.push_back(argument.data());
      values.push_back(nullptr);
      execv(program.c_str(), values.data());
      _exit(127);
    }
  }

  ~ServiceProcess() {
    if (process_ < 0) return;
    send_signal(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }

  ServiceProcess(const ServiceProcess&) = delete;
  ServiceProcess& operator=(const ServiceProcess&) = delete;

  /// @return the processor time of the process and all of its descendants so far [s].
  [[nodiscard]] double processor_seconds() const {
    std::map<pid_t, std::pair<pid_t, double>> processes;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      if (entry.path().filename().string().find_first_not_of("0123456789") != std::string::npos) {
        continue;
      }
      std::ifstream file(entry.path() / "stat");
      std::string text;
      std::getline(file, text);
      const auto end_of_name = text.rfind(')');
      if (end_of_name == std::string::npos) continue;
      std::istringstream rest(text.substr(end_of_name + 2));
      const std::vector<std::string> fields{std::istream_iterator<std::string>(rest), {}};
      processes[std::stoi(entry.path().filename().string())] = {
          std::stoi(fields.at(1)), std::stod(fields.at(11)) + std::stod(fields.at(12))};
    }
    double ticks = 0.0;
    for (const auto& [process, parent_and_time] : processes) {
      pid_t ancestor = process;
      while (ancestor > 1 && ancestor != process_ && processes.contains(ancestor)) {
        ancestor = processes[ancestor].first;
      }
      ticks += ancestor == process_ ? parent_and_time.second : 0.0;
    }
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }

 private:
  pid_t process_ = 0;
};

}  // namespace vdrive::test
