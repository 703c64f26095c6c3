// SPDX-License-Identifier: Apache-2.0
// Results of calls and settings of the environment, using the umbrella header only.
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using testing::HasSubstr;

Result<std::string> failed() {
  return Outcome::not_found("no axis 1.7");
}

using Names = Result<std::vector<std::string>>;

template <typename Kept>
using ValueOf = decltype(std::declval<Kept>().value());
template <typename Kept>
using DereferenceOf = decltype(*std::declval<Kept>());

// A named result lends its value; the value of a temporary is moved to the caller.
static_assert(std::is_same_v<ValueOf<Names&>, std::vector<std::string>&>);
static_assert(std::is_same_v<ValueOf<const Names&>, const std::vector<std::string>&>);
static_assert(std::is_same_v<ValueOf<Names>, std::vector<std::string>>);
static_assert(std::is_same_v<ValueOf<const Names>, std::vector<std::string>>);
static_assert(std::is_same_v<DereferenceOf<Names&>, std::vector<std::string>&>);
static_assert(std::is_same_v<DereferenceOf<const Names&>, const std::vector<std::string>&>);
static_assert(std::is_same_v<DereferenceOf<Names>, std::vector<std::string>>);
static_assert(std::is_same_v<DereferenceOf<const Names>, std::vector<std::string>>);

// Too long for the small buffer of a string.
Names names() {
  return std::vector<std::string>{"the axis that lifts the gantry",
                                  "the axis that turns the table"};
}

// The address sanitizer would report a dangling range.
TEST(Result, ThatNobodyKeepsIsTheRangeOfALoop) {
  std::string joined;
  for (const std::string& name : names().value()) joined += name + ";";
  for (const std::string& name : *names()) joined += name + ";";
  const std::string twice = "the axis that lifts the gantry;the axis that turns the table;";
  EXPECT_EQ(joined, twice + twice);
}

TEST(Result, ThatNobodyKeepsGivesItsValueAway) {
  auto&& moved = names().value();
  const auto& dereferenced = *names();
  EXPECT_EQ(moved, dereferenced);
  const Names kept = names();
  EXPECT_EQ(std::as_const(kept).value().size(), 2U);
}

TEST(Result, GivesItsValue) {
  Result<std::string> sut("at 5");
  EXPECT_EQ(sut.value(), "at 5");
  sut.value() = "at 6";
  EXPECT_EQ(*sut, "at 6");
  EXPECT_EQ(sut->size(), 4U);
  EXPECT_TRUE(sut.outcome());
}

TEST(Result, GivesAValueThatCanOnlyBeMoved) {
  const std::unique_ptr<int> moved = Result<std::unique_ptr<int>>(std::make_unique<int>(3)).value();
  EXPECT_EQ(*moved, 3);
}

TEST(Result, OfAFailureThrowsItsMessageWhenItsValueIsTaken) {
  try {
    (void)failed().value();
    FAIL() << "it has no value";
  } catch (const OutcomeError& error) {
    EXPECT_STREQ(error.what(), "no axis 1.7");
    EXPECT_EQ(error.outcome().kind(), OutcomeKind::not_found);
  }
  const Result<std::string> constant = failed();
  EXPECT_THROW((void)constant.value(), std::runtime_error);
}

TEST(Outcome, ThatIsNoSuccessIsThrownWhereTheProgramWantsIt) {
  EXPECT_NO_THROW(Outcome().or_throw());
  try {
    Outcome::refused(0x08000022, "enable of axis 1.1").or_throw();
    FAIL() << "it is no success";
  } catch (const OutcomeError& error) {
    EXPECT_EQ(error.outcome().kind(), OutcomeKind::refused);
    EXPECT_EQ(error.outcome().code(), 0x08000022U);
    EXPECT_EQ(error.what(), error.outcome().message());
  }
}

TEST(ResultDeathTest, DereferencingAFailureEndsTheProgramWithItsMessage) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Result<std::string> sut = failed();
  EXPECT_DEATH((void)*sut, "a failed result was used: no axis 1\\.7");
  EXPECT_DEATH((void)sut->size(), "a failed result was used: no axis 1\\.7");
  const Result<std::string>& constant = sut;
  EXPECT_DEATH((void)constant->size(), "no axis 1\\.7");
}

/// Restores VDRIVE_DOMAIN after a test.
class DefaultDomain : public testing::Test {
 protected:
  DefaultDomain() {
    if (const char* const text = std::getenv(kVariable)) before_ = text;  // NOLINT(*-mt-unsafe)
  }

  ~DefaultDomain() override { set(before_); }

  static void set(const std::optional<std::string>& text) {
    if (text) {
      setenv(kVariable, text->c_str(), 1);  // NOLINT(*-mt-unsafe)
    } else {
      unsetenv(kVariable);  // NOLINT(*-mt-unsafe)
    }
  }

  static std::string refusal() {
    try {
      const Session session;
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

 private:
  static constexpr const char* kVariable = "VDRIVE_DOMAIN";
  std::optional<std::string> before_;
};

TEST_F(DefaultDomain, IsTakenFromTheEnvironmentOrIs0) {
  set(std::nullopt);
  EXPECT_EQ(default_domain(), 0U);
  set("232");
  EXPECT_EQ(default_domain(), 232U);
}

TEST_F(DefaultDomain, RefusesTextThatIsNotADomain) {
  for (const char* const text : {"233", "-1", "5x", "x", " 5", "99999999999"}) {
    set(text);
    EXPECT_EQ(refusal(), std::string("VDRIVE_DOMAIN in the environment is '") + text +
                             "': a DDS domain must be a number from 0 to 232");
  }
  set("");
  EXPECT_THAT(refusal(), HasSubstr("VDRIVE_DOMAIN in the environment is set, but empty"));
}

}  // namespace
}  // namespace vdrive::client
