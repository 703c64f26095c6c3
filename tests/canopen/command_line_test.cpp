// SPDX-License-Identifier: Apache-2.0
#include "bridge/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::HasSubstr;

struct Ended {
  int code = 0;
  std::string output;
  std::string errors;
};

/// Runs the program in this process.
Ended run_with(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "vdrive-canopen");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Ended ended;
  ended.code = run_command_line(static_cast<int>(arguments.size()), arguments.data());
  ended.output = testing::internal::GetCapturedStdout();
  ended.errors = testing::internal::GetCapturedStderr();
  return ended;
}

TEST(CanopenCommandLine, PrintsHelpAndVersion) {
  const Ended help = run_with({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* const option : {"--bench", "--node-offset", "--socketcand", "--interface",
                                   "--gateway", "--sync-steps", "--dds-interface", "--state"}) {
    EXPECT_THAT(help.output, HasSubstr(option));
  }
  EXPECT_THAT(run_with({"--version"}).output, HasSubstr("vdrive-canopen "));
}

TEST(CanopenCommandLine, ChecksAConfiguration) {
  const Ended ended = run_with(
      {"--check", "--private", "--axes", "3", "--node-offset", "5", "--sync-steps", "1ms"});
  EXPECT_EQ(ended.code, 0) << ended.errors;
  EXPECT_EQ(ended.output, "vdrive-canopen: the configuration is valid\n");
}

TEST(CanopenCommandLine, NamesWhatWhereAndTheLimitOfAMistake) {
  const auto errors_of = [](const std::vector<const char*>& arguments) {
    const Ended ended = run_with(arguments);
    EXPECT_EQ(ended.code, 2) << ended.errors;
    return ended.errors;
  };
  EXPECT_THAT(errors_of({"--check", "--bench", "0"}),
              HasSubstr("--bench: '0' must be a whole number from 1 to 65535"));
  EXPECT_THAT(errors_of({"--check", "--axes", "128"}),
              HasSubstr("--axes: '128' must be a whole number from 1 to 127"));
  EXPECT_THAT(errors_of({"--check", "--node-offset", "127"}), HasSubstr("from -65534 to 126"));
  EXPECT_THAT(errors_of({"--check", "--socketcand", "nowhere"}),
              HasSubstr("vdrive-canopen: --socketcand 'nowhere'"));
  EXPECT_THAT(errors_of({"--check", "--domain", "233"}), HasSubstr("from 0 to 232"));
  EXPECT_THAT(errors_of({"--check", "--private", "--domain", "5"}),
              HasSubstr("leave out the network options"));
  EXPECT_THAT(errors_of({"--check", "--config", "/nothing/here"}), HasSubstr("/nothing/here"));
  EXPECT_THAT(errors_of({"--check", "--private", "--bench-config", "/nothing/here"}),
              HasSubstr("bench 1: "));
  EXPECT_THAT(errors_of({"--check", "--private", "--axes", "127", "--node-offset", "5"}),
              HasSubstr("bench 1: axis 1.123 would be node 128: node ids are 1 to 127"));
  for (const char* const option :
       {"--config", "--state", "--clock", "--sync-steps", "--bench-config"}) {
    EXPECT_THAT(errors_of({"--check", "--private", option, ""}),
                HasSubstr("vdrive-canopen: " + std::string(option) + ": its value is empty"));
  }
  EXPECT_THAT(errors_of({"--nonsense"}), HasSubstr("'--nonsense' is not an option"));
}

TEST(CanopenCommandLine, FailsWhereItCannotListen) {
  // An address reserved for documentation (RFC 5737), which no machine has.
  const Ended ended = run_with({"--private", "--socketcand", "192.0.2.1:1"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.errors, HasSubstr("192.0.2.1:1"));
}

}  // namespace
}  // namespace vdrive::canopen
