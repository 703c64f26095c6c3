// SPDX-License-Identifier: Apache-2.0
// The closed mode: real programs with credentials made by deploy/security.
#include "vdrive/wire/security.hpp"

#include "security/material.hpp"
#include "support/process_tree.hpp"
#include "support/signals.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"
#include "wire/closed_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;

/// A service in closed mode; the destructor ends it.
class ClosedService {
 public:
  /// @param program the program, with any words that precede its own arguments
  ClosedService(const fs::path& material, const std::string& words,
                std::vector<std::string> program = {VDRIVE_SERVICE}) {
    program.insert(program.end(), {"--security", material.string(), "--log-level", "error"});
    for (const std::string& word : tool_arguments(words)) program.push_back(word);
    const std::string first = program.front();
    program.erase(program.begin());
    process_ = std::make_unique<Process>(first, std::move(program));
  }

  ~ClosedService() {
    process_->send(SIGTERM);
    (void)process_->wait();
  }

  ClosedService(const ClosedService&) = delete;
  ClosedService& operator=(const ClosedService&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return process_->id(); }

 private:
  std::unique_ptr<Process> process_;
};

class ClosedBench : public testing::Test {
 protected:
  void serve(const std::string& words = "") { service_.emplace(service_material_, words); }

  /// Runs the tool as this member. It waits long for a bench, because authentication is slow on a
  /// busy machine.
  static Finished as(const fs::path& member, const std::string& words) {
    return tool(words + " --timeout 20 --security " + member.string());
  }

  Authority authority_;
  fs::path service_material_ = authority_.member("service bench");
  fs::path controller_ = authority_.member("controller desk");
  std::optional<ClosedService> service_;
};

// In lock-step the watchdog does not count time lost by a busy machine.
TEST_F(ClosedBench, AllowsAControllerToMoveAnAxis) {
  serve("--clock lockstep");
  const Finished enabled = as(controller_, "enable 1.1");
  EXPECT_EQ(enabled.code, 0) << enabled.errors;
  const Finished moved = as(controller_, "move 1.1 2000 --velocity 20000");
  EXPECT_EQ(moved.code, 0) << moved.errors;
  const Finished read = as(controller_, "read 1.1 0x6064");
  EXPECT_EQ(read.code, 0) << read.errors;
  EXPECT_THAT(read.output, HasSubstr("2000"));
}

client::SessionOptions closed_session(const fs::path& member) {
  return {.domain = test_domain(),
          .security = member.string(),
          .find_timeout = 20s,
          .silence = 20s,
          .program = "owner"};
}

TEST_F(ClosedBench, NamesTheProgramThatHoldsAnAxis) {
  serve("--clock lockstep");
  client::Session owner(closed_session(controller_));
  ASSERT_TRUE(owner.axis("1.1").value().acquire());
  const Finished refused = as(controller_, "enable 1.1");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.errors, HasSubstr("axis 1.1 is controlled by owner (process "));
  const Finished seen = as(authority_.member("viewer hall"), "status 1.1");
  EXPECT_THAT(seen.output, HasSubstr("owner       owner (process "));
}

// Fast DDS 3.1 does not take the member's end from the guard, but detects it itself.
TEST_F(ClosedBench, ForgetsAMemberThatWasKilled) {
  const auto controller = wire::make_participant(
      {.domain = test_domain(), .security = controller_.string()}, "controller");
  const wire::Publication<msg::Request> requests(*controller);
  Process member(VDRIVE_VISITOR, {std::to_string(test_domain()), "vdrive client",
                                  "security=" + service_material_.string()});
  ASSERT_TRUE(holds_soon([&] {
    return requests.matched() == 1;
  }));
  member.send(SIGKILL);
  static_cast<void>(member.wait());
  const auto killed = std::chrono::steady_clock::now();
  EXPECT_TRUE(holds_soon([&] {
    return requests.matched() == 0;
  }));
  EXPECT_LT(std::chrono::steady_clock::now() - killed, 6s);
}

// A network whose permissions were made before session names existed.
TEST_F(ClosedBench, WorksWithoutNamesWherePermissionsDoNotHaveTheirTopics) {
  for (const fs::path& member : {service_material_, controller_}) {
    const std::string document = read_file(member / "permissions.smime");
    const std::size_t begin = document.find("<?xml");
    const std::string end = "</dds>";
    std::string xml = document.substr(begin, document.find(end) + end.size() - begin);
    const std::size_t whole = xml.size();
    for (const std::string topic : {"session", "bench_session"}) {
      const std::string row = "<topic>vdrive/v1/" + topic + "</topic>";
      xml.erase(xml.find(row), row.size());
    }
    ASSERT_LT(xml.size(), whole);
    write_file(authority_.directory() / "old.xml", xml);
    authority_.sign(authority_.directory() / "old.xml", member / "permissions.smime");
  }
  serve("--clock lockstep");
  client::Session owner(closed_session(controller_));
  ASSERT_TRUE(owner.axis("1.1").value().acquire());
  const Finished refused = as(controller_, "enable 1.1");
  EXPECT_EQ(refused.code, 5) << refused.errors;
  EXPECT_THAT(refused.errors,
              HasSubstr("axis 1.1 is controlled by an unknown program, session 0x"));
}

TEST_F(ClosedBench, ReadsCredentialsFromTheEnvironment) {
  serve();
  setenv("VDRIVE_SECURITY", controller_.c_str(), 1);  // NOLINT(*-mt-unsafe)
  const Finished listed = tool("list --timeout 20");
  unsetenv("VDRIVE_SECURITY");  // NOLINT(*-mt-unsafe)
  EXPECT_EQ(listed.code, 0) << listed.errors;
}

// Each step is answered by the wire that took its request or, after a repetition, by the next one.
TEST_F(ClosedBench, StepsInLockStepByAProcessThatMayBeKilled) {
  serve("--clock lockstep");
  client::Session session({.domain = test_domain(),
                           .security = controller_.string(),
                           .find_timeout = 20s,
                           .silence = 20s});
  std::atomic<std::uint64_t> steps = 0;
  std::atomic<bool> stop = false;
  std::string wrong;
  std::thread stepper([&] {
    for (std::uint64_t tick = 1; !stop && wrong.empty(); ++tick) {
      const auto reached = session.step(1, 1);
      if (!reached) {
        wrong = "step " + std::to_string(tick) + ": " + reached.outcome().message();
      } else if (reached.value() != tick) {
        wrong = "step " + std::to_string(tick) + " reached " + std::to_string(reached.value());
      }
      steps = tick;
    }
  });
  for (int kills = 0; kills < 3; ++kills) {
    const std::uint64_t before = steps;
    EXPECT_TRUE(holds_soon([&] {
      return steps > before + 20;
    })) << "kill "
        << kills;
    const pid_t wire = wire_of(service_->id());
    EXPECT_NE(wire, 0) << "by default the wire of a closed bench is a process";
    if (wire != 0) send_signal(wire, SIGKILL);
    EXPECT_TRUE(holds_soon([&] {
      const pid_t next = wire_of(service_->id());
      return next != 0 && next != wire;
    }));
  }
  const std::uint64_t before = steps;
  EXPECT_TRUE(holds_soon([&] {
    return steps > before + 1;
  })) << "the last wire steps too";
  stop = true;
  stepper.join();
  EXPECT_EQ(wrong, "");
}

class ClosedBenchByClock : public ClosedBench, public testing::WithParamInterface<const char*> {};

TEST_P(ClosedBenchByClock, ShowsEverythingToAViewerAndRefusesItsCommands) {
  const fs::path viewer = authority_.member("viewer hall");
  serve(GetParam());
  std::vector<std::string> commands{"list", "status 1.1", "watch 1.1 --count 1"};
  if (std::string(GetParam()) == "--clock realtime")
    commands.emplace_back("record - 1.1 --count 3");
  for (const std::string& words : commands) {
    const Finished seen = as(viewer, words);
    EXPECT_EQ(seen.code, 0) << words << ": " << seen.errors;
    EXPECT_THAT(seen.output, HasSubstr("1.1")) << words;
  }
  for (const char* const words :
       {"enable 1.1", "move 1.1 100", "read 1.1 0x6041", "write 1.1 0x6040 6", "step 1", "rate 0",
        "power-cycle 1.1", "snapshot take", "disturb 1.1 blocked_load"}) {
    const Finished refused = as(viewer, words);
    EXPECT_EQ(refused.code, 5) << words << ": " << refused.errors;
    EXPECT_THAT(refused.errors + refused.output,
                HasSubstr("the permissions of this identity do not allow commands"))
        << words;
  }
}

INSTANTIATE_TEST_SUITE_P(Clocks, ClosedBenchByClock,
                         testing::Values("--clock realtime", "--clock lockstep",
                                         "--clock realtime --rate 0"),
                         [](const auto& clock) {
                           const std::string words = clock.param;
                           return words.find("rate") != std::string::npos       ? "paused"
                                  : words.find("lockstep") != std::string::npos ? "lockstep"
                                                                                : "realtime";
                         });

TEST_F(ClosedBench, IsInvisibleToStrangers) {
  serve();
  const Authority other;
  const fs::path of_other = other.member("controller desk");
  ASSERT_EQ(as(controller_, "list").code, 0) << "the bench is there";
  const Finished open = tool("list --timeout 2");
  EXPECT_EQ(open.code, 3) << "without material: " << open.output;
  const Finished unknown = tool("list --timeout 2 --security " + of_other.string());
  EXPECT_EQ(unknown.code, 3) << "with a certificate of another CA: " << unknown.output;
}

TEST_F(ClosedBench, DoesNotSeeAnOpenBench) {
  const RunningService open("--clock lockstep");
  EXPECT_EQ(tool("list --timeout 20").code, 0);
  EXPECT_EQ(tool("list --timeout 2 --security " + controller_.string()).code, 3);
}

// The library repeats a lost authentication message only after a second.
TEST_F(ClosedBench, IsSearchedForFiveSeconds) {
  const auto begin = std::chrono::steady_clock::now();
  const Finished nobody = tool("list --security " + controller_.string());
  EXPECT_EQ(nobody.code, 3) << nobody.output;
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 5s);
}

// The clock of the service is two days ahead, so a certificate of one day has expired for the
// service but not for the client.
TEST_F(ClosedBench, RefusesAnExpiredCertificate) {
  // Preloaded as by the faketime wrapper, which would not pass on signals.
  const std::string library = shell("ls /usr/lib/*/faketime/libfaketime.so.1").text;
  if (!library.starts_with("/usr/lib")) GTEST_SKIP() << "faketime is not installed";
  const fs::path expired = authority_.member("controller yesterday --days 1");
  const ClosedService service(
      service_material_, "--clock lockstep",
      {"/usr/bin/env", "LD_PRELOAD=" + library.substr(0, library.find('\n')), "FAKETIME=+2d",
       "DONT_FAKE_MONOTONIC=1", VDRIVE_SERVICE});
  const Finished valid = as(controller_, "list");
  ASSERT_EQ(valid.code, 0) << valid.errors;
  const Finished refused = tool("list --timeout 2 --security " + expired.string());
  EXPECT_EQ(refused.code, 3) << refused.output << refused.errors;
}

// ---- faulty credentials -------------------------------------------------------------------------

struct Flaw {
  const char* name;
  /// Spoils the credentials of a service. @return their directory
  std::function<fs::path(const Authority&, const fs::path&)> make;
  const char* complaint;
};

fs::path with_governance(const Authority& authority, const fs::path& member,
                         const std::string& from, const std::string& to) {
  std::string text = read_file(std::string(VDRIVE_SOURCE_DIR) + "/deploy/security/governance.xml");
  const std::size_t place = text.find(from);
  if (place == std::string::npos) throw std::logic_error("no " + from);
  write_file(member / "governance.xml", text.replace(place, from.size(), to));
  authority.sign(member / "governance.xml", member / "governance.smime");
  return member;
}

Flaw open_governance(const char* name, const std::string& from, const std::string& to,
                     const char* complaint) {
  return {name,
          [from, to](const Authority& authority, const fs::path& member) {
            return with_governance(authority, member, from, to);
          },
          complaint};
}

Flaw missing(const char* name, const char* file, const char* complaint) {
  return {name,
          [file](const Authority&, const fs::path& member) {
            fs::remove(member / file);
            return member;
          },
          complaint};
}

Flaw copied(const char* name, const char* file, const std::string& from, const char* complaint) {
  return {name,
          [file, from](const Authority& authority, const fs::path& member) {
            const fs::path other = authority.member(from);
            fs::copy_file(other / file, member / file, fs::copy_options::overwrite_existing);
            return member;
          },
          complaint};
}

Flaw other_member(const char* name, const std::string& words, const char* complaint) {
  return {name,
          [words](const Authority& authority, const fs::path&) {
            return authority.member(words);
          },
          complaint};
}

std::vector<Flaw> flaws() {
  return {
      {"NoDirectory",
       [](const Authority&, const fs::path& member) {
         return member / "nowhere";
       },
       "identity_ca.pem: cannot be read: No such file or directory"},
      missing("NoCertificate", "certificate.pem", "certificate.pem: cannot be read"),
      missing("NoKey", "private_key.pem", "private_key.pem: cannot be read"),
      missing("NoGovernance", "governance.smime", "governance.smime: cannot be read"),
      missing("NoPermissions", "permissions.smime", "permissions.smime: cannot be read"),
      copied("KeyOfAnother", "private_key.pem", "service other",
             "private_key.pem: is not the key of"),
      copied("PermissionsOfAnother", "permissions.smime", "service other",
             "permissions.smime: grants nothing to the certificate's subject "
             "CN=bench,OU=service,O=vdrive"),
      {"CertificateOfAnotherCa",
       [](const Authority&, const fs::path& member) {
         const Authority other;
         const fs::path stranger = other.member("service bench");
         for (const char* const file : {"certificate.pem", "private_key.pem"}) {
           fs::copy_file(stranger / file, member / file, fs::copy_options::overwrite_existing);
         }
         return member;
       },
       "certificate.pem: was not issued by"},
      {"ChangedGovernance",
       [](const Authority&, const fs::path& member) {
         std::string text = read_file(member / "governance.smime");
         const std::string closed = "_participants>FALSE";
         text.replace(text.find(closed), closed.size(), "_participants>TRUE");
         write_file(member / "governance.smime", text);
         return member;
       },
       "governance.smime: was not signed by"},
      other_member("Expired", "service old --from 2020-01-01T00:00:00 --to 2021-01-01T00:00:00",
                   "certificate.pem: expired at Jan  1 00:00:00 2021 GMT"),
      other_member("NotYetValid",
                   "service young --from 2090-01-01T00:00:00 --to 2091-01-01T00:00:00",
                   "certificate.pem: is not valid before Jan  1 00:00:00 2090 GMT"),
      other_member("RoleOfAViewer", "viewer hall", "do not allow publishing vdrive/v1/"),
      open_governance("Unauthenticated", "participants>FALSE", "participants>TRUE",
                      "allow_unauthenticated_participants must be FALSE"),
      open_governance("AnybodyMayJoin", "join_access_control>TRUE", "join_access_control>FALSE",
                      "enable_join_access_control must be TRUE"),
      open_governance("AnybodyMayWrite", "write_access_control>TRUE", "write_access_control>FALSE",
                      "enable_write_access_control must be TRUE"),
      open_governance("AnybodyMayRead", "read_access_control>TRUE", "read_access_control>FALSE",
                      "enable_read_access_control must be TRUE"),
      open_governance("DataInClear", "data_protection_kind>ENCRYPT", "data_protection_kind>NONE",
                      "data_protection_kind is NONE"),
      open_governance("MessagesInClear", "rtps_protection_kind>ENCRYPT",
                      "rtps_protection_kind>NONE", "rtps_protection_kind is NONE"),
      open_governance("MessagesSignedOnly", "rtps_protection_kind>ENCRYPT",
                      "rtps_protection_kind>SIGN", "rtps_protection_kind is SIGN, must be ENCRYPT"),
      open_governance("OtherTopics", "expression>*<", "expression>other<",
                      "has no <topic_rule> for topic vdrive/v1/command"),
      open_governance("OtherDomain", "<max>232", "<max>0", "has no <domain_rule> for domain"),
  };
}

class AServiceWithoutUsableCredentials : public testing::TestWithParam<Flaw> {};

TEST_P(AServiceWithoutUsableCredentials, RefusesToStartAndNamesTheReason) {
  const Authority authority;
  const fs::path material = GetParam().make(authority, authority.member("service bench"));
  const Finished refused =
      Process(VDRIVE_SERVICE, tool_arguments("--log-level error --security " + material.string()))
          .wait();
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr(GetParam().complaint));
}

INSTANTIATE_TEST_SUITE_P(Flaws, AServiceWithoutUsableCredentials, testing::ValuesIn(flaws()),
                         [](const auto& flaw) {
                           return std::string(flaw.param.name);
                         });

TEST(ClosedMode, ExcludesADiscoveryServer) {
  const Finished refused = tool("list --security /nowhere --discovery-server 10.0.0.9:11811");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("cannot be combined with a discovery server"));
}

TEST(ClosedMode, AClientWithoutCredentialsDoesNotStartOpen) {
  const Finished refused = tool("list --security /nowhere");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("/nowhere/identity_ca.pem: cannot be read"));
  EXPECT_THAT(refused.output, IsEmpty());
}

TEST(ClosedMode, AConfigurationIsCheckedWithItsCredentials) {
  const Authority authority;
  const fs::path member = authority.member("service bench");
  const fs::path file = authority.directory() / "bench.yaml";
  write_file(file, "network:\n  security: " + member.string() + "\n");
  EXPECT_EQ(Process(VDRIVE_SERVICE, {"--check", file}).wait().code, 0);
  fs::remove(member / "private_key.pem");
  const Finished refused = Process(VDRIVE_SERVICE, {"--check", file}).wait();
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("private_key.pem: cannot be read"));
}

// ---- the self-test -----------------------------------------------------------------------------

/// A participant like that of a service during its self-test.
struct Tested {
  explicit Tested(const wire::NetworkSettings& settings)
      : participant(wire::make_participant(settings, "tested")),
        states(*participant),
        others(*participant, [](const msg::BenchState&, const wire::Source&) {}) {}

  std::unique_ptr<wire::Participant> participant;
  wire::Publication<msg::BenchState> states;
  wire::Subscription<msg::BenchState> others;
};

TEST(SelfTest, RefusesABenchThatStrangersFind) {
  const wire::NetworkSettings open{.domain = test_domain()};
  Tested tested(open);
  try {
    service::check_closed(*tested.participant, open);
    FAIL() << "accepted";
  } catch (const wire::NetworkError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the bench is open"));
  }
}

TEST(SelfTest, AcceptsABenchThatOnlyMembersFind) {
  const Authority authority;
  const wire::NetworkSettings closed{.domain = test_domain(),
                                     .security = authority.member("service bench")};
  Tested tested(closed);
  EXPECT_NO_THROW(service::check_closed(*tested.participant, closed));
}

// ---- the scripts -------------------------------------------------------------------------------

TEST(SecurityScripts, NeverOverwriteFiles) {
  const Authority authority;
  const fs::path member = authority.member("service bench");
  const std::string key = read_file(authority.directory() / "identity_ca_key.pem");
  const std::string certificate = read_file(member / "certificate.pem");
  const std::string scripts = std::string(VDRIVE_SOURCE_DIR) + "/deploy/security/";
  EXPECT_EQ(shell(scripts + "make_authority.sh " + authority.directory().string()).code, 0);
  EXPECT_EQ(read_file(authority.directory() / "identity_ca_key.pem"), key);
  const ShellResult again =
      shell(scripts + "make_member.sh " + authority.directory().string() + " viewer bench");
  EXPECT_EQ(again.code, 1);
  EXPECT_THAT(again.text, HasSubstr("already exists; remove it first to replace the member"));
  EXPECT_EQ(read_file(member / "certificate.pem"), certificate);
}

TEST(SecurityScripts, MakeKeysReadableByTheirOwnerOnly) {
  const Authority authority;
  const fs::path member = authority.member("service bench");
  for (const fs::path& key :
       {authority.directory() / "identity_ca_key.pem",
        authority.directory() / "permissions_ca_key.pem", member / "private_key.pem"}) {
    EXPECT_EQ(fs::status(key).permissions(), fs::perms::owner_read | fs::perms::owner_write) << key;
  }
}

TEST(SecurityScripts, RefuseUnknownArguments) {
  const Authority authority;
  const std::string script = std::string(VDRIVE_SOURCE_DIR) + "/deploy/security/make_member.sh ";
  const std::string directory = authority.directory().string();
  for (const std::string& words :
       {directory + " king bench", directory + " service ../bench", directory + " service",
        directory + " service bench --days 0", directory + " service bench --from yesterday",
        std::string("/nowhere service bench")}) {
    EXPECT_EQ(shell(script + words).code, 1) << words;
  }
  EXPECT_FALSE(fs::exists(authority.directory() / "members" / "bench"));
}

}  // namespace
}  // namespace vdrive::test
