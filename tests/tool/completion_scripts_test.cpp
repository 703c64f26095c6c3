// SPDX-License-Identifier: Apache-2.0
// Executes the scripts of `vdrive completion` in their shells.
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace vdrive::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

std::string script(const std::string& shell) {
  return Process(VDRIVE_TOOL, {"completion", shell}).wait().output;
}

/// Executes the script, then a line of the shell, with the tool in PATH on the domain of this test.
std::vector<std::string> carried_out(const std::string& shell, const std::string& line) {
  const std::string program = "/usr/bin/" + shell;
  const std::string directory = std::filesystem::path(VDRIVE_TOOL).parent_path();
  setenv("PATH", (directory + ":/usr/bin:/bin").c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  setenv("VDRIVE_DOMAIN", std::to_string(test_domain()).c_str(), 1);  // NOLINT(*-mt-unsafe)
  return Process(program, {"-c", script(shell) + line}).wait().lines();
}

class CompletionScript : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists("/usr/bin/" + GetParam())) GTEST_SKIP() << "no " << GetParam();
  }

  /// @param words of the command line after `vdrive`; the last one is unfinished and unquoted
  [[nodiscard]] std::vector<std::string> offers(const std::string& words, int count) const {
    if (GetParam() == "bash") {
      return carried_out("bash", "\nCOMP_WORDS=(vdrive " + words +
                                     "); COMP_CWORD=" + std::to_string(count) +
                                     "; _vdrive; printf '%s\\n' \"${COMPREPLY[@]}\"");
    }
    if (GetParam() == "fish") return carried_out("fish", "\ncomplete -C 'vdrive " + words + "'");
    // Stand-ins for the completion system of zsh: its setup, and the functions called by the
    // script.
    std::string system = "compdef() { }\n_files() { }\ncompadd() { shift; print -l -- $@ }\n";
    return carried_out_zsh(system, words, count);
  }

 private:
  static std::vector<std::string> carried_out_zsh(const std::string& system,
                                                  const std::string& words, int count) {
    const std::string directory = std::filesystem::path(VDRIVE_TOOL).parent_path();
    setenv("PATH", (directory + ":/usr/bin:/bin").c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    setenv("VDRIVE_DOMAIN", std::to_string(test_domain()).c_str(), 1);  // NOLINT(*-mt-unsafe)
    const std::string call =
        "\nwords=(vdrive " + words + "); CURRENT=" + std::to_string(count + 1) + "; _vdrive";
    return Process("/usr/bin/zsh", {"-f", "-c", system + script("zsh") + call}).wait().lines();
  }
};

TEST_P(CompletionScript, OffersCommandsAndObjects) {
  EXPECT_THAT(offers("mo", 1), Contains("move"));
  EXPECT_THAT(offers("read 1.1 profile_vel", 3), Contains("profile_velocity"));
}

TEST_P(CompletionScript, OffersThePresentAxes) {
  const RunningService service("--clock lockstep");
  EXPECT_THAT(offers("enable 1.", 2), ElementsAre("1.1", "1.2"));
}

TEST_P(CompletionScript, OffersNoAxesWithoutABench) {
  EXPECT_THAT(offers("enable 1.", 2), testing::Not(Contains("1.1")));
}

INSTANTIATE_TEST_SUITE_P(Shells, CompletionScript, testing::Values("bash", "zsh", "fish"),
                         [](const auto& name) {
                           return name.param;
                         });

}  // namespace
}  // namespace vdrive::test
