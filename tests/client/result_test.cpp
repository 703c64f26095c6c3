// SPDX-License-Identifier: Apache-2.0
// Results of calls and settings of the environment, with the umbrella header only.
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::client {
namespace {

using testing::HasSubstr;

Result<std::string> failed() {
  return Outcome::not_found("no axis 1.7");
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

TEST(ResultDeathTest, DereferencingAFailureEndsTheProgramWithItsMessage) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Result<std::string> sut = failed();
  EXPECT_DEATH((void)*sut, "a failed result was used: no axis 1\\.7");
  EXPECT_DEATH((void)sut->size(), "a failed result was used: no axis 1\\.7");
  const Result<std::string>& constant = sut;
  EXPECT_DEATH((void)constant->size(), "no axis 1\\.7");
}

/// VDRIVE_DOMAIN for the length of a test.
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
                             "': a DDS domain is a number from 0 to 232");
  }
  set("");
  EXPECT_THAT(refusal(), HasSubstr("VDRIVE_DOMAIN in the environment is set, but empty"));
}

}  // namespace
}  // namespace vdrive::client
