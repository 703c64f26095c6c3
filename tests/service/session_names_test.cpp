// SPDX-License-Identifier: Apache-2.0
#include "publish/session_names.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::service {
namespace {

constexpr std::uint32_t kNamedBench = 3;

msg::SessionName said_by(std::uint64_t session, const std::string& program,
                         std::uint32_t bench = kNamedBench) {
  msg::SessionName name;
  name.bench = bench;
  name.session = session;
  name.program = program;
  name.process = 4711;
  name.host = "bench-host";
  return name;
}

/// @return the sessions whose names have to be published, in order.
std::vector<std::uint64_t> published_names(SessionNames& names) {
  std::vector<std::uint64_t> sessions;
  for (; names.next() != nullptr; names.pop()) sessions.push_back(names.next()->session);
  return sessions;
}

TEST(SessionNames, PassOnWhatAProgramSaysAtAPlace) {
  SessionNames sut(kNamedBench);
  EXPECT_EQ(sut.next(), nullptr);
  ASSERT_TRUE(sut.note(said_by(7, "first")));
  ASSERT_TRUE(sut.note(said_by(8, "second")));
  ASSERT_NE(sut.next(), nullptr);
  EXPECT_EQ(sut.next()->bench, kNamedBench);
  EXPECT_EQ(sut.next()->place, 0U);
  EXPECT_EQ(sut.next()->session, 7U);
  EXPECT_EQ(sut.next()->program, "first");
  EXPECT_EQ(sut.next()->process, 4711U);
  EXPECT_EQ(sut.next()->host, "bench-host");
  sut.pop();
  EXPECT_EQ(sut.next()->place, 1U);
}

TEST(SessionNames, PublishWhatIsUnchangedOnce) {
  SessionNames sut(kNamedBench);
  ASSERT_TRUE(sut.note(said_by(7, "first")));
  EXPECT_FALSE(sut.note(said_by(7, "first")));
  EXPECT_EQ(published_names(sut), std::vector<std::uint64_t>{7});
  EXPECT_TRUE(sut.note(said_by(7, "renamed")));
  ASSERT_NE(sut.next(), nullptr);
  EXPECT_EQ(sut.next()->place, 0U) << "it keeps its place";
}

TEST(SessionNames, LeaveOutWhatBelongsToNoSessionOrToAnotherBench) {
  SessionNames sut(kNamedBench);
  EXPECT_FALSE(sut.note(said_by(0, "nobody")));
  EXPECT_FALSE(sut.note(said_by(7, "elsewhere", kNamedBench + 1)));
  EXPECT_EQ(sut.next(), nullptr);
}

TEST(SessionNames, GiveThePlaceOfTheFirstToOneThatFindsNoRoom) {
  SessionNames sut(kNamedBench);
  for (std::uint64_t session = 1; session <= SessionNames::kMost; ++session) {
    ASSERT_TRUE(sut.note(said_by(session, "program")));
  }
  (void)published_names(sut);
  for (const std::uint64_t place : {0U, 1U}) {
    ASSERT_TRUE(sut.note(said_by(1'000 + place, "late")));
    ASSERT_NE(sut.next(), nullptr);
    EXPECT_EQ(sut.next()->place, place);
    EXPECT_EQ(sut.next()->session, 1'000 + place);
    sut.pop();
  }
}

TEST(SessionNames, AreAllPublishedAgainForAWireThatIsNew) {
  SessionNames sut(kNamedBench);
  ASSERT_TRUE(sut.note(said_by(7, "first")));
  ASSERT_TRUE(sut.note(said_by(8, "second")));
  (void)published_names(sut);
  sut.begin_again();
  EXPECT_EQ(published_names(sut), (std::vector<std::uint64_t>{7, 8}));
}

}  // namespace
}  // namespace vdrive::service
