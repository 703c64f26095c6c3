// SPDX-License-Identifier: Apache-2.0
// The program vdrived: processes, signals, exit codes.
#include "service/probe.hpp"
#include "support/process_tree.hpp"
#include "support/signals.hpp"
#include "support/test_domain.hpp"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A running program and its output; ended by the destructor.
class Process {
 public:
  /// @param output the file for its standard output; none = together with its errors
  explicit Process(std::vector<std::string> arguments, const char* output = nullptr) {
    arguments.insert(arguments.begin(), VDRIVE_SERVICE);
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ < 0) throw std::runtime_error("fork");
    if (child_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      // NOLINTNEXTLINE(*-vararg): the only interface there is
      if (output != nullptr) dup2(open(output, O_WRONLY), STDOUT_FILENO);
      close(ends[0]);
      close(ends[1]);
      std::vector<char*> values;
      for (auto& argument : arguments) values.push_back(argument.data());
      values.push_back(nullptr);
      execv(VDRIVE_SERVICE, values.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }

  ~Process() {
    if (child_ > 0) {
      send_signal(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
    std::fclose(output_);
  }

  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const { send_signal(child_, signal); }

  [[nodiscard]] pid_t id() const { return child_; }

  /// Reads to the end of the output and waits. @return the exit code, or -signal.
  int wait() {
    std::array<char, 512> line{};
    while (std::fgets(line.data(), line.size(), output_) != nullptr) text_ += line.data();
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  pid_t child_ = 0;
  std::FILE* output_ = nullptr;
  std::string text_;
};

std::vector<std::string> with_domain(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--domain", std::to_string(test_domain())});
  return arguments;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

class SignalledService : public testing::TestWithParam<int> {};

TEST_P(SignalledService, GoesOfflineAndEndsWithinTwoSeconds) {
  Process service(with_domain({"--clock", "lockstep"}));
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const auto begin = Clock::now();
  service.send(GetParam());
  EXPECT_EQ(service.wait(), 0) << service.text();
  EXPECT_LT(Clock::now() - begin, 2s);
  EXPECT_TRUE(probe.wait_until([&] {
    return probe.seen_offline();
  }));
}

INSTANTIATE_TEST_SUITE_P(Signals, SignalledService, testing::Values(SIGINT, SIGTERM),
                         [](const auto& signal) {
                           return signal.param == SIGINT ? "sigint" : "sigterm";
                         });

TEST(SignalledService, EndsInTheMiddleOfALongStep) {
  Process service(with_domain({"--clock", "lockstep", "--axes", "2000"}));
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  std::optional<msg::Reply> reply;
  std::thread client([&] {
    reply = probe.step(1'000'000);
  });
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_state() && probe.seen_state()->tick > 0;
  }));
  const auto begin = Clock::now();
  service.send(SIGTERM);
  EXPECT_EQ(service.wait(), 0) << service.text();
  EXPECT_LT(Clock::now() - begin, 2s);
  client.join();
  ASSERT_TRUE(reply) << "a client that steps receives the reason";
  EXPECT_EQ(reply->reason, msg::Reason::shutting_down);
}

TEST(ServiceProcess, EndsWhenItsBenchNumberIsInUse) {
  Process first(with_domain({"--bench", "7"}));
  Probe probe(test_domain(), 7);
  ASSERT_TRUE(probe.find_bench());
  Process second(with_domain({"--bench", "7"}));
  EXPECT_EQ(second.wait(), 5);
  EXPECT_NE(
      second.text().find("bench 7 is already served in domain " + std::to_string(test_domain()) +
                         " by process " + std::to_string(first.id()) + " on " + host_name() +
                         " (incarnation "),
      std::string::npos)
      << second.text();
  EXPECT_TRUE(probe.read(1, 0x6041)) << "the first one continues";
  Process other(with_domain({"--bench", "8"}));
  Probe probe_of_other(test_domain(), 8);
  EXPECT_TRUE(probe_of_other.find_bench());
}

TEST(ServiceProcess, ThatStartedLaterEndsWhenTwoShareABenchNumber) {
  Process older(with_domain({"--bench", "9"}));
  Probe probe(test_domain(), 9);
  ASSERT_TRUE(probe.find_bench());
  older.send(SIGSTOP);  // silent while the other checks the bench number
  Process younger(with_domain({"--bench", "9"}));
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_descriptions().back().incarnation != probe.incarnation;
  }));
  older.send(SIGCONT);
  EXPECT_EQ(younger.wait(), 5);
  EXPECT_NE(younger.text().find("bench 9 is already served in domain"), std::string::npos)
      << younger.text();
  EXPECT_NE(younger.text().find(" by process " + std::to_string(older.id()) + " on " + host_name()),
            std::string::npos)
      << younger.text();
  EXPECT_TRUE(probe.read(1, 0x6041));
}

TEST(ServiceProcess, StartsAgainAtOnceAfterAKill) {
  for (int round = 0; round < 3; ++round) {
    Process service(with_domain({"--bench", "3"}));
    Probe probe(test_domain(), 3);
    ASSERT_TRUE(probe.find_bench());
    const auto shared_memory = shared_memory_of(service.id());
    service.send(SIGKILL);
    EXPECT_EQ(service.wait(), -SIGKILL);
    for (const auto& file : shared_memory) EXPECT_FALSE(std::filesystem::exists(file)) << file;
  }
}

TEST(ServiceProcess, PublishesTheFirstStatusOfAThousandAxesWithinASecond) {
  const auto begin = Clock::now();
  Process service(with_domain({"--axes", "1000"}));
  Probe probe(test_domain());
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_status().has_value();
  }));
  // A benchmark checks the budget; this bound only catches gross delays, on a loaded machine, too.
  EXPECT_LT(Clock::now() - begin, 3s);
  EXPECT_EQ(probe.status()->parts, 4U);
}

TEST(ServiceProcess, PrintsItsVersion) {
  Process service({"--version"});
  EXPECT_EQ(service.wait(), 0);
  EXPECT_TRUE(service.text().starts_with("vdrived ")) << service.text();
}

TEST(ServiceProcess, FailsWhenItsAnswerCouldNotBeWritten) {
  for (const char* const flag : {"--help-config", "--print-config", "--version"}) {
    Process service({flag}, "/dev/full");
    EXPECT_EQ(service.wait(), 1) << flag;
    EXPECT_EQ(service.text(),
              "vdrived: standard output could not be written: No space left on device\n")
        << flag;
  }
}

TEST(ServiceProcess, RefusesUnknownArguments) {
  Process flag({"--nonsense"});
  EXPECT_EQ(flag.wait(), 2);
  Process mode({"--clock", "warp"});
  EXPECT_EQ(mode.wait(), 2);
  EXPECT_NE(mode.text().find("realtime, lockstep, freerun"), std::string::npos);
  for (const std::string clock : {"freerun", "lockstep"}) {
    Process rate({"--clock", clock, "--rate", "2"});
    EXPECT_EQ(rate.wait(), 2);
    EXPECT_NE(rate.text().find("--rate cannot be used with the clock " + clock), std::string::npos);
  }
  Process steppers({"--steppers", "2"});
  EXPECT_EQ(steppers.wait(), 2);
  EXPECT_NE(steppers.text().find("--steppers cannot be used with the clock realtime"),
            std::string::npos);
  Process axes({"--axes", "16385"});
  EXPECT_EQ(axes.wait(), 2);
  EXPECT_EQ(axes.text(), "vdrived: --axes: '16385' must be a whole number from 1 to 16384\n");
  Process preset({"--preset", "ball-skrew"});
  EXPECT_EQ(preset.wait(), 2);
  EXPECT_NE(preset.text().find("pick-and-place"), std::string::npos) << "the names are listed";
}

TEST(ServiceProcess, HasAxesOfAPreset) {
  Process three({"--axes", "3", "--preset", "ball-screw", "--print-config"});
  EXPECT_EQ(three.wait(), 0);
  EXPECT_NE(three.text().find("axis3"), std::string::npos);
  EXPECT_NE(three.text().find("409.6"), std::string::npos) << "user units in a millimetre";
  Process one({"--preset", "winder", "--print-config"});
  EXPECT_EQ(one.wait(), 0);
  EXPECT_NE(one.text().find("axis1"), std::string::npos);
  EXPECT_EQ(one.text().find("axis2"), std::string::npos);
}

// CLI11 alone reports "Could not convert" without the limits, and refuses notations that files
// allow.
TEST(ServiceProcess, NamesOptionValueAndLimitsOfANumber) {
  struct Row {
    const char* option;
    const char* limits;
  };

  for (const Row& row : {Row{"--axes", "a whole number from 1 to 16384"},
                         Row{"--bench", "a whole number from 1 to 65535"},
                         Row{"--domain", "a whole number from 0 to 232"},
                         Row{"--period", "a whole number from 125 to 10000"},
                         Row{"--threads", "a whole number from 1 to 64"},
                         Row{"--metrics", "a whole number from 0 to 65535"},
                         Row{"--rate", "0 (paused) or from 0.1 to 100"}}) {
    for (const char* const value : {"1e9", "1e99", "-1", "many"}) {
      Process service({row.option, value, "--print-config"});
      EXPECT_EQ(service.wait(), 2) << row.option << " " << value;
      EXPECT_EQ(service.text(), std::string("vdrived: ") + row.option + ": '" + value +
                                    "' must be " + row.limits + "\n");
    }
  }
  Process service({"--axes", "0x2", "--domain", "010", "--period", "1e3", "--print-config"});
  EXPECT_EQ(service.wait(), 0);
  EXPECT_NE(service.text().find("domain: 10\n"), std::string::npos) << service.text();
}

// CLI11 takes an empty value for a missing one. The bench would start open, on the default domain,
// or without a journal.
TEST(ServiceProcess, RefusesAnEmptyValue) {
  for (const char* const flag :
       {"--config", "--check", "--clock", "--period", "--bench", "--axes", "--domain", "--security",
        "--rate", "--threads", "--metrics", "--state", "--journal", "--replay"}) {
    Process service({flag, "", "--print-config"});
    EXPECT_EQ(service.wait(), 2) << flag;
    EXPECT_NE(service.text().find(std::string("vdrived: ") + flag), std::string::npos)
        << service.text();
  }
  for (const char* const variable : {"VDRIVE_SECURITY", "VDRIVE_DOMAIN", "VDRIVE_BENCH"}) {
    setenv(variable, "", 1);  // NOLINT(*-mt-unsafe)
    Process service({"--print-config"});
    unsetenv(variable);  // NOLINT(*-mt-unsafe)
    EXPECT_EQ(service.wait(), 2) << variable;
    EXPECT_NE(service.text().find(std::string(variable) + " in the environment is set, but empty"),
              std::string::npos)
        << service.text();
  }
}

// A pod gets the number of its bench from VDRIVE_BENCH.
TEST(ServiceProcess, TakesItsNumberFromTheEnvironment) {
  setenv("VDRIVE_BENCH", "12", 1);  // NOLINT(*-mt-unsafe)
  Process service({"--print-config"});
  Process flagged({"--bench", "13", "--print-config"});
  unsetenv("VDRIVE_BENCH");  // NOLINT(*-mt-unsafe)
  EXPECT_EQ(service.wait(), 0);
  EXPECT_NE(service.text().find("  number: 12\n"), std::string::npos) << service.text();
  EXPECT_EQ(flagged.wait(), 0);
  EXPECT_NE(flagged.text().find("  number: 13\n"), std::string::npos) << flagged.text();
}

TEST(ServiceProcess, ShowsABadValueEscapedAndShortened) {
  for (const char* const flag : {"--clock", "--threads", "--log-level", "--period"}) {
    Process service({flag, "a\n\x1B[31m" + std::string(100'000, 'b')});
    EXPECT_EQ(service.wait(), 2) << flag;
    EXPECT_NE(service.text().find(R"(a\n\x1B[31mb)"), std::string::npos) << service.text();
    EXPECT_LT(service.text().size(), 600U) << flag;
  }
}

TEST(ServiceProcess, NamesTheFirstUnknownOption) {
  Process service({"--axis", "3", "--verbose"});
  EXPECT_EQ(service.wait(), 2);
  EXPECT_NE(service.text().find("vdrived: '--axis' is not an option (did you mean '--axes'?)"),
            std::string::npos)
      << service.text();
}

TEST(ServiceProcess, SaysHowAConfigurationIsNamed) {
  Process service({"c0.yaml"});
  EXPECT_EQ(service.wait(), 2);
  EXPECT_NE(service.text().find("vdrived: 'c0.yaml' is one argument too many; to use it as the "
                                "configuration: vdrived --config c0.yaml\n"),
            std::string::npos)
      << service.text();
  Process two({"--check", "c0.yaml", "c1.yaml"});
  EXPECT_EQ(two.wait(), 2);
  EXPECT_NE(two.text().find("'c1.yaml' is one argument too many"), std::string::npos) << two.text();
}

// CLI11 takes --config for the file name of --check.
TEST(ServiceProcess, ShowsTheFormOfACheckWithoutItsFile) {
  const std::string form = "vdrived: --check needs the file itself: vdrived --check ";
  for (const std::vector<std::string>& named : std::vector<std::vector<std::string>>{
           {"--check", "--config", "c0.yaml"},
           {"--check", "--config=c0.yaml"},
           {"--config", "c0.yaml", "--check"},
           {"--check", "--log-level", "info", "--config", "c0.yaml"}}) {
    Process service(named);
    EXPECT_EQ(service.wait(), 2);
    EXPECT_EQ(service.text(), form + "c0.yaml\n");
  }
  Process alone({"--check"});
  EXPECT_EQ(alone.wait(), 2);
  EXPECT_EQ(alone.text(), form + "FILE\n");
  Process config({"--config", "--check"});
  EXPECT_EQ(config.wait(), 2);
  EXPECT_EQ(config.text(), form + "FILE\n");
}

TEST(ServiceProcess, SuggestsTheNearestValueOfAnOption) {
  Process clock({"--clock", "lockstp"});
  EXPECT_EQ(clock.wait(), 2);
  EXPECT_NE(clock.text().find("(did you mean 'lockstep'?)"), std::string::npos) << clock.text();
  Process level({"--log-level", "debg"});
  EXPECT_EQ(level.wait(), 2);
  EXPECT_NE(level.text().find("(did you mean 'debug'?)"), std::string::npos) << level.text();
}

// A replay takes its number of threads from the command line. If that is out of range, the exit
// code must not be 1, which means that a tick differs or is missing.
TEST(ServiceProcess, ChecksOptionsEvenIfTheyAreNotUsed) {
  for (const char* const mode : {"--replay", "--check"}) {
    for (const char* const threads : {"0", "65"}) {
      Process service({mode, "/nonexistent", "--threads", threads});
      EXPECT_EQ(service.wait(), 2) << mode;
      EXPECT_NE(service.text().find("from 1 to 64"), std::string::npos) << service.text();
    }
  }
}

class ConfigurationFile : public testing::Test {
 protected:
  ConfigurationFile()
      : file_(std::filesystem::temp_directory_path() /
              ("vdrive-" + std::to_string(getpid()) + ".yaml")) {}

  ~ConfigurationFile() override { std::filesystem::remove(file_); }

  void write(const std::string& text) const { std::ofstream(file_) << text; }

  std::filesystem::path file_;
};

TEST_F(ConfigurationFile, IsCheckedWithoutAStartOfTheService) {
  write("bench: {number: 3}\n");
  Process good({"--check", file_.string()});
  EXPECT_EQ(good.wait(), 0);
  write("axes: [{number: 1, parameters: {user_position_lower_limit: -5}}]\n");
  Process odd({"--check", file_.string()});
  EXPECT_EQ(odd.wait(), 0);
  EXPECT_NE(odd.text().find("warning: " + file_.string() +
                            ":1: axes[0].parameters.user_position_lower_limit = -5: axis 1 axis1"),
            std::string::npos)
      << odd.text();
  write("bench: {number: 3}\nclock: {period_us: 7}\n");
  Process bad({"--check", file_.string()});
  EXPECT_EQ(bad.wait(), 1);
  EXPECT_NE(bad.text().find(file_.string() + ":2: clock.period_us = 7: must be"), std::string::npos)
      << bad.text();
}

TEST_F(ConfigurationFile, HasItsWarningsWithTheirLinesInTheLogOfTheStart) {
  write("clock: {mode: lockstep}\naxes: [{number: 1, parameters: {\"0x607D:1\": -5}}]\n");
  Process service(with_domain({"--config", file_.string()}));
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  service.send(SIGTERM);
  EXPECT_EQ(service.wait(), 0);
  EXPECT_NE(service.text().find("configuration=\"" + file_.string() +
                                ":2: axes[0].parameters.0x607D:1 = -5: axis 1 axis1: "),
            std::string::npos)
      << service.text();
}

TEST_F(ConfigurationFile, IsCheckedToItsEnd) {
  write("bench: {number: 0}\nclock: {period_us: 7}\n");
  Process bad({"--check", file_.string()});
  EXPECT_EQ(bad.wait(), 1);
  for (const char* const place :
       {":1: bench.number = 0: must be", ":2: clock.period_us = 7: must"}) {
    EXPECT_NE(bad.text().find("vdrived: " + file_.string() + place), std::string::npos)
        << bad.text();
  }
}

TEST_F(ConfigurationFile, CanBeAPrintedConfiguration) {
  Process first({"--print-config", "--bench", "12", "--axes", "3", "--clock", "lockstep"});
  ASSERT_EQ(first.wait(), 0);
  write(first.text());
  Process second({"--print-config", "--config", file_.string()});
  ASSERT_EQ(second.wait(), 0);
  EXPECT_EQ(second.text(), first.text());
  Process overridden({"--print-config", "--config", file_.string(), "--bench", "13"});
  ASSERT_EQ(overridden.wait(), 0);
  EXPECT_NE(overridden.text().find("number: 13"), std::string::npos);
}

}  // namespace
}  // namespace vdrive::test
