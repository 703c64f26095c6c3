// SPDX-License-Identifier: Apache-2.0
// Stored parameters, stored and read by commands.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace vdrive::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kRead = "read 1.1 profile_velocity";

class StoredParameters : public testing::Test {
 protected:
  [[nodiscard]] std::string flags(const std::string& clock) const {
    return "--clock " + clock + " --state " + directory.path().string();
  }

  [[nodiscard]] fs::path file(const std::string& suffix = "") const {
    return directory.path() / ("bench-1.parameters" + suffix);
  }

  static void expect_done(const std::string& words) {
    const Finished finished = call(words);
    EXPECT_EQ(finished.code, 0) << words << ": " << finished.errors;
  }

  TemporaryDirectory directory;
};

TEST_F(StoredParameters, AreStoredByAWriteOfTheirObject) {
  {
    BenchOnWire bench(flags("lockstep"));
    EXPECT_THAT(call("read 1.1 0x1010:1 0x1011:1 --json").output, HasSubstr("\"value\":1"));
    expect_done("write 1.1 profile_velocity 4321");
    const Finished wrong = call("write 1.1 0x1010:1 0x64616F6C");
    EXPECT_EQ(wrong.code, 5);
    EXPECT_THAT(wrong.errors, HasSubstr("0x08000020"));
    EXPECT_FALSE(fs::exists(file()));
    expect_done("write 1.1 store_all_parameters 0x65766173");
    EXPECT_TRUE(fs::exists(file())) << "when the answer is there it is durable";
    EXPECT_THAT(call("store 1.1 --json").output,
                HasSubstr(R"({"axis":"1.1","command":"store","outcome":"ok")"));
  }
  const BenchOnWire bench(flags("lockstep"));
  EXPECT_THAT(call(kRead).output, HasSubstr("4321"));
}

TEST_F(StoredParameters, AreReportedWithTheirNumberAndTheirFile) {
  const BenchOnWire bench(flags("lockstep"));
  const std::string objects = std::to_string(kStoredRows.size());
  const std::string place =
      file().filename().string() + " in the state directory of the service of bench 1";
  EXPECT_EQ(call("store 1.1").output,
            "1.1: stored " + objects + " parameters (1010h:01) in " + place + "\n");
  EXPECT_TRUE(fs::exists(file()));
  EXPECT_EQ(call("restore 1.1").output,
            "1.1: no stored parameters (1011h:01) are left in " + place +
                "; the configured values are in force after the next power cycle\n");
  EXPECT_EQ(call("store 1.1 --json").output,
            R"({"axis":"1.1","command":"store","outcome":"ok","objects":)" + objects +
                R"(,"group":"1010h:01","file":"bench-1.parameters"})" + "\n");
  EXPECT_EQ(call("restore 1.1 --json").output,
            R"({"axis":"1.1","command":"restore","outcome":"ok","group":"1011h:01",)"
            R"("file":"bench-1.parameters"})"
            "\n");
}

TEST_F(StoredParameters, NeedAStateDirectory) {
  const BenchOnWire bench("--clock lockstep");
  for (const char* const words : {"store 1.1", "restore 1.1", "write 1.1 0x1010:1 0x65766173"}) {
    const Finished finished = call(words);
    EXPECT_EQ(finished.code, 5) << words;
    EXPECT_THAT(finished.errors, HasSubstr("0x08000020")) << words;
  }
}

TEST_F(StoredParameters, CauseAResettableFaultWhenDamaged) {
  std::ofstream(file()) << "nonsense";
  const BenchOnWire bench(flags("lockstep"));
  expect_done("step 2");
  EXPECT_THAT(call("read 1.1 0x603F 0x6041 --json").output, HasSubstr("\"value\":21808"));  // 5530h
  EXPECT_EQ(call("enable 1.1").code, 5);
  expect_done("reset 1.1");
  expect_done("enable 1.1");
  expect_done("store 1.1");
  EXPECT_TRUE(fs::exists(file(".damaged")));
}

}  // namespace
}  // namespace vdrive::test
