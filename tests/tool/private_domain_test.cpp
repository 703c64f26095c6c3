// SPDX-License-Identifier: Apache-2.0
// Domains of private benches are exclusive on a machine, across users. The tests run in a network
// namespace, so they do not occupy the domains of other tests.
#include "private_domain.hpp"

#include "support/signals.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/wire/ports.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::process {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr uid_t kStranger = 65'534;
constexpr std::size_t kAll = PrivateDomain::kCount;

void open_loopback() {
  const Descriptor control(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  std::string_view("lo").copy(&request.ifr_name[0], IFNAMSIZ - 1);
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  ioctl(control.get(), SIOCSIFFLAGS, &request);  // NOLINT(*-vararg): the only interface there is
}

/// Claims some domains.
/// @return their numbers.
std::set<std::uint32_t> claim(std::vector<std::unique_ptr<PrivateDomain>>& kept,
                              std::size_t count) {
  std::set<std::uint32_t> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    kept.push_back(std::make_unique<PrivateDomain>());
    numbers.insert(kept.back()->number());
  }
  return numbers;
}

/// A process of another user that calls a function, then waits to be killed by the destructor.
class Stranger {
 public:
  /// @param act returns the domains it has claimed
  explicit Stranger(const std::function<std::set<std::uint32_t>()>& act) {
    std::array<int, 2> pipe{};
    if (::pipe(pipe.data()) != 0) throw std::runtime_error("pipe");
    child_ = fork();
    if (child_ < 0) throw std::runtime_error("fork");
    if (child_ == 0) live(act, pipe[1]);
    close(pipe[1]);
    std::uint32_t domain = 0;
    while (read(pipe[0], &domain, sizeof domain) == sizeof domain && domain != 0) {
      domains_.insert(domain);
    }
    close(pipe[0]);
  }

  ~Stranger() {
    test::send_signal(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }

  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;

  [[nodiscard]] const std::set<std::uint32_t>& domains() const { return domains_; }

 private:
  [[noreturn]] static void live(const std::function<std::set<std::uint32_t>()>& act, int result) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (setgid(kStranger) != 0 || setuid(kStranger) != 0) _exit(1);
    try {
      std::set<std::uint32_t> domains = act();
      domains.insert(0);  // reported last, as an end mark
      for (auto domain = domains.rbegin(); domain != domains.rend(); ++domain) {
        if (write(result, &*domain, sizeof *domain) != sizeof *domain) _exit(1);
      }
      while (true) pause();
    } catch (...) {
      _exit(1);
    }
  }

  pid_t child_ = 0;
  std::set<std::uint32_t> domains_;
};

/// Takes the ports of all domains, as another program might.
/// @param is_shared with SO_REUSEADDR, as a DDS participant does
/// @return the domains whose port was free
std::set<std::uint32_t> occupy_all(bool is_shared) {
  std::set<std::uint32_t> domains;
  for (std::uint32_t i = 0; i < kAll; ++i) {
    const int one = socket(AF_INET, SOCK_DGRAM, 0);  // stays open until the process ends
    const int value = is_shared ? 1 : 0;
    setsockopt(one, SOL_SOCKET, SO_REUSEADDR, &value, sizeof value);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port =
        htons(static_cast<std::uint16_t>(wire::group_port(PrivateDomain::kFirst + i)));
    // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
    if (bind(one, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
      domains.insert(PrivateDomain::kFirst + i);
    }
  }
  return domains;
}

std::string refusal() {
  try {
    const PrivateDomain one;
  } catch (const std::exception& error) {
    return error.what();
  }
  return "none";
}

class PrivateDomains : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "two users need the rights of root";
    if (unshare(CLONE_NEWNET) != 0) GTEST_SKIP() << "a network namespace is not permitted here";
    open_loopback();
  }
};

TEST_F(PrivateDomains, OfTwoUsersDiffer) {
  std::vector<std::unique_ptr<PrivateDomain>> own;
  (void)claim(own, 8);
  own.clear();  // what these leave behind must not disturb other users
  const Stranger stranger([] {
    static std::vector<std::unique_ptr<PrivateDomain>> kept;
    return claim(kept, kAll - PrivateDomain::kMostOfOneUser);
  });
  ASSERT_EQ(stranger.domains().size(), kAll - PrivateDomain::kMostOfOneUser);
  std::set<std::uint32_t> all = claim(own, PrivateDomain::kMostOfOneUser);
  all.insert(stranger.domains().begin(), stranger.domains().end());
  EXPECT_EQ(all.size(), kAll) << "each domain once";
}

TEST_F(PrivateDomains, AreBoundedForOneUser) {
  std::vector<std::unique_ptr<PrivateDomain>> own;
  (void)claim(own, PrivateDomain::kMostOfOneUser);
  EXPECT_THAT(refusal(), HasSubstr("has 64 of the DDS domains 20 to 99, the limit for one user"));
  own.pop_back();
  EXPECT_EQ(refusal(), "none");
}

TEST_F(PrivateDomains, AreNotTakenAwayByAStrangerWhoTakesPartInAll) {
  const Stranger stranger([] {
    return occupy_all(true);
  });
  ASSERT_EQ(stranger.domains().size(), kAll);
  std::vector<std::unique_ptr<PrivateDomain>> own;
  EXPECT_EQ(claim(own, 20).size(), 20U) << "each of another number";
}

TEST_F(PrivateDomains, ThatAStrangerDeniesAreRefusedWithItsUser) {
  const Stranger stranger([] {
    return occupy_all(false);
  });
  ASSERT_EQ(stranger.domains().size(), kAll);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("all DDS domains from 20 to 99 are in use"),
                               HasSubstr("80 by user 65534")));
}

TEST_F(PrivateDomains, FollowNoLinkOfAStrangerInTheDirectoryForTemporaryFiles) {
  const test::TemporaryDirectory directory;
  const std::filesystem::path shared = directory.path() / "tmp";
  const std::filesystem::path target = directory.path() / "target";
  std::filesystem::create_directory(shared);
  for (std::uint32_t i = 0; i < kAll; ++i) {
    const std::string name =
        "vdrive-test-domain-" + std::to_string(PrivateDomain::kFirst + i) + ".lock";
    std::filesystem::create_symlink(target, shared / name);
  }
  ASSERT_EQ(setenv("TMPDIR", shared.c_str(), 1), 0);  // NOLINT(concurrency-mt-unsafe): one thread
  std::vector<std::unique_ptr<PrivateDomain>> own;
  EXPECT_EQ(claim(own, 4).size(), 4U);
  unsetenv("TMPDIR");  // NOLINT(concurrency-mt-unsafe): one thread
  EXPECT_FALSE(std::filesystem::exists(target));
}

TEST_F(PrivateDomains, StayFreeOfOthersWhenTheirParticipantsHaveGone) {
  const PrivateDomain one;
  {
    // Like a participant of the domain, which shares the port.
    const Descriptor participant(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const int value = 1;
    setsockopt(participant.get(), SOL_SOCKET, SO_REUSEADDR, &value, sizeof value);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(wire::group_port(one.number())));
    // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
    ASSERT_EQ(bind(participant.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
              0);
  }
  std::vector<std::unique_ptr<PrivateDomain>> others;
  EXPECT_FALSE(claim(others, PrivateDomain::kMostOfOneUser - 1).contains(one.number()));
}

}  // namespace
}  // namespace vdrive::process
