// SPDX-License-Identifier: Apache-2.0
// `vdrive shell` from a pipe.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Shell : public testing::Test {
 protected:
  BenchOnWire bench_{"--clock lockstep"};
};

TEST_F(Shell, ExecutesPipedLinesInOneSessionAndContinuesAfterErrors) {
  const Finished finished = call("shell",
                                 "enable 1.1   # a comment\n"
                                 "\n"
                                 "move 1.1 100\n"
                                 "enabel 1.1\n"
                                 "expect 1.1 position 5\n"
                                 "read 1.1 position --json\n"
                                 "status 1.1 --json\n"
                                 "exit\n"
                                 "disable 1.1\n");
  EXPECT_EQ(finished.code, 2) << "of the first command that failed";
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr("did you mean 'enable'?"),
                    HasSubstr("expected 5 UU (0.44 deg), actual 100 UU (8.79 deg)")));
  EXPECT_THAT(finished.output, AllOf(HasSubstr("100 UU"), HasSubstr("\"value\":100")));
  EXPECT_EQ(finished.output.find("\"owner\":null"), std::string::npos) << "the session keeps it";
  EXPECT_THAT(call("status 1.1 --json").output,
              AllOf(HasSubstr("Operation enabled"), HasSubstr("\"owner\":null")));
}

// At 1000 UU/s² the velocity is reached after 100 s. Until then the shell's session keeps the axis.
TEST_F(Shell, LetsAnAxisGoOnWhoseVelocityTakesTooLong) {
  const Finished finished = call("shell",
                                 "enable 1.1\n"
                                 "velocity 1.1 100000 --acceleration 1000 --timeout 1s\n"
                                 "expect 1.1 velocity_demand_value > 0\n"
                                 "halt 1.1 --wait\n");
  EXPECT_EQ(finished.code, 4) << finished.errors;
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr(" of 100000 UU/s (8789.06 deg/s), still changing; to stop it: "),
                    testing::Not(HasSubstr("expected"))));
}

TEST_F(Shell, AcceptsALastLineWithoutALineEnd) {
  const Finished finished = call("shell", "nothing\nread 1.1 position");
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("'nothing' is not a command; 'help' lists all commands"));
  EXPECT_THAT(finished.output, HasSubstr("1.1 position load_position_actual_value = 0"));
}

TEST_F(Shell, ShowsItsCommandsAndTheHelpOfOne) {
  const Finished all = call("shell", "help\n");
  EXPECT_EQ(all.code, 0) << all.errors;
  EXPECT_THAT(all.output, AllOf(HasSubstr("'help COMMAND'"), HasSubstr("\nMotion:\n  move "),
                                testing::Not(HasSubstr("\n  doctor "))))
      << "doctor is no command of a shell";
  const Finished one = call("shell", "help move\n");
  EXPECT_EQ(one.code, 0) << one.errors;
  EXPECT_THAT(one.output, HasSubstr("--acceleration"));
  EXPECT_EQ(one.output, call("shell", "move --help\n").output);
  const Finished unknown = call("shell", "help mvoe\nhelp move home\n");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.errors, AllOf(HasSubstr("'mvoe' is not a command (did you mean 'move'?)"),
                                    HasSubstr("'home' is one argument too many for 'help'")));
}

TEST_F(Shell, RefusesALineBeyondTheLimitAndContinues) {
  const Finished finished =
      call("shell", "enable " + std::string(60'000, 'x') + "\nread 1.1 position\n");
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("the line has more than 32768 bytes"));
  EXPECT_THAT(finished.output, HasSubstr("= 0"));
}

TEST_F(Shell, RunsAScenario) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "a.scn";
  std::ofstream(file) << "enable 1.1\n";
  EXPECT_THAT(call("shell", "run " + file + "\n").output, HasSubstr("passed  " + file));
}

}  // namespace
}  // namespace vdrive::test
