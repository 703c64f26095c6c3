// SPDX-License-Identifier: Apache-2.0
#include "admission.hpp"

#include "page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::gateway {
namespace {

using testing::HasSubstr;

UpgradeRequest good() {
  return {.target = "/",
          .host = "127.0.0.1:8765",
          .origin = "",
          .protocols = "foxglove.sdk.v1",
          .authorization = ""};
}

TEST(Admission, AcceptsBothSubprotocolsAndReturnsTheFirstOffered) {
  UpgradeRequest request = good();
  EXPECT_EQ(admit(request, {}).status, 101U);
  EXPECT_EQ(admit(request, {}).subprotocol, "foxglove.sdk.v1");
  request.protocols = "foxglove.websocket.v1";
  EXPECT_EQ(admit(request, {}).subprotocol, "foxglove.websocket.v1");
  request.protocols = "other, foxglove.websocket.v1 ,foxglove.sdk.v1";
  EXPECT_EQ(admit(request, {}).subprotocol, "foxglove.websocket.v1");
}

TEST(Admission, AnswersOtherSubprotocolsWith400) {
  UpgradeRequest request = good();
  for (const char* offered : {"", "mqtt", "foxglove.sdk.v2", "foxglove.sdk.v1x", ",,"}) {
    request.protocols = offered;
    EXPECT_EQ(admit(request, {}).status, 400U) << offered;
  }
}

TEST(Admission, RefusesForeignOrigins) {
  UpgradeRequest request = good();
  request.origin = "http://127.0.0.1:8765";
  EXPECT_EQ(admit(request, {}).status, 101U);
  for (const char* origin : {"http://evil.example", "null", "http://127.0.0.1:8766",
                             "http://127.0.0.1:8765.evil.example", "file://"}) {
    request.origin = origin;
    EXPECT_EQ(admit(request, {}).status, 403U) << origin;
  }
  const AdmissionRules rules{.origins = {"https://studio.example.org"}};
  request.origin = "https://studio.example.org";
  EXPECT_EQ(admit(request, rules).status, 101U);
}

TEST(Admission, RefusesHostNamesThatAreNotAllowed) {
  UpgradeRequest request = good();
  for (const char* host : {"localhost:8765", "LOCALHOST", "[::1]:8765", "10.0.0.5"}) {
    request.host = host;
    EXPECT_EQ(admit(request, {}).status, 101U) << host;
  }
  for (const char* host : {"evil.example:8765", "", "127.0.0.1.evil.example", "[::1", "bench"}) {
    request.host = host;
    EXPECT_EQ(admit(request, {}).status, 403U) << host;
  }
  request.host = "bench:8765";
  EXPECT_EQ(admit(request, {.hosts = {"bench"}}).status, 101U);
}

TEST(Admission, NeedsTheTokenInTheTargetOrTheHeader) {
  const AdmissionRules rules{.token = "0123456789abcdef"};
  UpgradeRequest request = good();
  EXPECT_EQ(admit(request, rules).status, 401U);
  EXPECT_THAT(admit(request, rules).reason, HasSubstr("?token="));
  for (const char* target : {"/?token=0123456789abcdeF", "/?token=0123456789abcdef0",
                             "/?token=", "/?xtoken=0123456789abcdef", "/token=0123456789abcdef"}) {
    request.target = target;
    EXPECT_EQ(admit(request, rules).status, 401U) << target;
  }
  request.target = "/?a=b&token=0123456789abcdef&c";
  EXPECT_EQ(admit(request, rules).status, 101U);
  request.target = "/";
  request.authorization = "Bearer 0123456789abcdef";
  EXPECT_EQ(admit(request, rules).status, 101U);
}

constexpr std::array kFiles{PageFile{"index.html", "<p>"}, PageFile{"assets/a-1f.js", "x"}};

TEST(Page, ServesItsFilesWithTypeAndCaching) {
  const PageAnswer index = find_page_file(kFiles, "/?token=abc");
  EXPECT_EQ(index.status, 200U);
  EXPECT_EQ(index.bytes, "<p>");
  EXPECT_EQ(index.content_type, "text/html; charset=utf-8");
  EXPECT_EQ(index.cache_control, "no-cache");
  const PageAnswer script = find_page_file(kFiles, "/assets/a-1f.js");
  EXPECT_EQ(script.content_type, "text/javascript; charset=utf-8");
  EXPECT_THAT(script.cache_control, HasSubstr("immutable"));
  for (const char* target : {"/other", "/../etc/passwd", "/assets/", "//index.html"}) {
    EXPECT_EQ(find_page_file(kFiles, target).status, 404U) << target;
  }
}

TEST(Page, ExplainsHowToBuildAMissingPage) {
  const PageAnswer answer = find_page_file({}, "/");
  EXPECT_EQ(answer.status, 200U);
  EXPECT_THAT(std::string(answer.bytes), HasSubstr("deploy/build.sh"));
  EXPECT_EQ(find_page_file({}, "/x").status, 404U);
}

}  // namespace
}  // namespace vdrive::gateway
