// SPDX-License-Identifier: Apache-2.0
#include "tool/process.hpp"

#include "support/deadline.hpp"
#include "support/signals.hpp"
#include "support/test_domain.hpp"
#include "vdrive/client/session.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace vdrive::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{120};
constexpr std::chrono::seconds kStart{60};  // of a service on a busy machine

std::vector<std::string> split(const std::string& words) {
  std::istringstream stream(words);
  std::vector<std::string> result;
  for (std::string word; stream >> word;) result.push_back(word);
  return result;
}

std::array<int, 2> make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  return ends;
}

/// Appends the available bytes.
/// @return false at the end of file.
bool read_some(int descriptor, std::string& text) {
  std::array<char, 4096> block{};
  const ssize_t count = read(descriptor, block.data(), block.size());
  if (count > 0) text.append(block.data(), static_cast<std::size_t>(count));
  return count > 0;
}

/// @return the bench number in these arguments, if any.
std::optional<std::uint32_t> bench_of(const std::vector<std::string>& arguments) {
  const auto option = std::ranges::find(arguments, "--bench");
  if (option == arguments.end() || option + 1 == arguments.end()) return std::nullopt;
  return static_cast<std::uint32_t>(std::stoul(*(option + 1)));
}

void close_if_open(int& descriptor) {
  if (descriptor >= 0) close(std::exchange(descriptor, -1));
}

/// @param ahead bytes read beyond the previous line
std::string line_of(int file, std::string& ahead) {
  std::size_t end = ahead.find('\n');
  while (end == std::string::npos && read_some(file, ahead)) end = ahead.find('\n');
  if (end == std::string::npos) return std::exchange(ahead, {});
  std::string line = ahead.substr(0, end);
  ahead.erase(0, end + 1);
  return line;
}

/// Reports a crash: a test that does not check the exit status of the program would only miss a
/// deadline. tests/checks/failures.py looks for this line.
void report_crash(const std::string& program, int status) {
  constexpr std::array kCrashes{SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV};
  if (!WIFSIGNALED(status) || std::ranges::count(kCrashes, WTERMSIG(status)) == 0) return;
  std::cerr << "[signal] " + program + " was ended by signal " + std::to_string(WTERMSIG(status)) +
                   "\n";
}

}  // namespace

std::vector<std::string> Finished::lines() const {
  std::istringstream stream(output);
  std::vector<std::string> result;
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

Process::Process(const std::string& program, std::vector<std::string> arguments,
                 const std::string& input)
    : program_(program), start_(Clock::now()) {
  arguments.insert(arguments.begin(), program);
  std::vector<char*> values;
  for (std::string& argument : arguments) values.push_back(argument.data());
  values.push_back(nullptr);
  const auto in = make_pipe();
  const auto out = make_pipe();
  const auto err = make_pipe();
  child_ = fork();
  if (child_ < 0) throw std::runtime_error("fork");
  if (child_ == 0) {
    // A test that is killed, for example by its time limit, takes the program with it. Otherwise
    // the program would disturb the next test in the same domain.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(in[0], STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    execv(program.c_str(), values.data());
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  close(err[1]);
  output_ = out[0];
  errors_ = err[0];
  const bool written =
      write(in[1], input.data(), input.size()) == static_cast<ssize_t>(input.size());
  close(in[1]);
  if (!written) throw std::runtime_error("input not taken");
}

Process::~Process() {
  if (child_ > 0) {
    send_signal(child_, SIGKILL);
    int status = 0;
    waitpid(child_, &status, 0);
    report_crash(program_, status);
  }
  close_if_open(output_);
  close_if_open(errors_);
}

void Process::send(int signal) const {
  if (child_ > 0) send_signal(child_, signal);
}

std::string Process::read_line() {
  return line_of(output_, read_ahead_);
}

std::string Process::read_error_line() {
  return line_of(errors_, errors_ahead_);
}

void Process::stop_reading() {
  close_if_open(output_);
}

Finished Process::wait() {
  Finished finished;
  finished.output = std::exchange(read_ahead_, {});
  finished.errors = std::exchange(errors_ahead_, {});
  // Each piece of output restarts the time limit, so a program that keeps writing may continue.
  auto deadline = Clock::now() + kPatience;
  std::array<pollfd, 2> open{pollfd{output_, POLLIN, 0}, pollfd{errors_, POLLIN, 0}};
  while (open[0].fd >= 0 || open[1].fd >= 0) {
    if (poll(open.data(), open.size(), 1000) != 0) {
      deadline = Clock::now() + kPatience;
    } else if (Clock::now() > deadline) {
      report_missed_deadline(program_ + " did neither write nor end", kPatience);
      send(SIGKILL);
    }
    if (open[0].revents != 0 && !read_some(output_, finished.output)) open[0].fd = -1;
    if (open[1].revents != 0 && !read_some(errors_, finished.errors)) open[1].fd = -1;
  }
  int status = 0;
  waitpid(std::exchange(child_, 0), &status, 0);
  report_crash(program_, status);
  finished.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  finished.duration = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start_);
  return finished;
}

Finished tool(const std::string& words, const std::string& input) {
  return tool(split(words), input);
}

Finished tool(std::vector<std::string> arguments, const std::string& input) {
  arguments.insert(arguments.begin(), {"--domain", std::to_string(test_domain())});
  return Process(VDRIVE_TOOL, std::move(arguments), input).wait();
}

std::vector<std::string> tool_arguments(const std::string& words) {
  std::vector<std::string> arguments = split(words);
  arguments.insert(arguments.begin(), {"--domain", std::to_string(test_domain())});
  return arguments;
}

RunningService::RunningService(const std::string& words)
    : process_(VDRIVE_SERVICE,
               split(words +
                     (words.find("--log-level") == std::string::npos ? " --log-level off --domain "
                                                                     : " --domain ") +
                     std::to_string(test_domain()))) {
  client::SessionOptions options;
  options.domain = test_domain();
  options.find_timeout = kStart;
  client::Session session(options);
  // Other services may be running, so look for this bench number if there is one.
  const auto bench = bench_of(split(words));
  const bool is_there =
      bench ? static_cast<bool>(session.find_bench(bench)) : !session.find_benches().empty();
  if (!is_there) throw std::runtime_error(missed_deadline("the service did not start", kStart));
}

RunningService::~RunningService() {
  process_.send(SIGTERM);
}

Finished RunningService::stop() {
  process_.send(SIGTERM);
  return process_.wait();
}

void RunningService::kill() {
  process_.send(SIGKILL);
  (void)process_.wait();
}

}  // namespace vdrive::test
