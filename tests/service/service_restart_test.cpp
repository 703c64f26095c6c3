// SPDX-License-Identifier: Apache-2.0
// A service of a thousand axes is killed again and again: 8 rounds, more with more effort
// (support/effort.hpp).
#include "service/probe.hpp"
#include "support/effort.hpp"
#include "support/process_tree.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kAxes = 1'000;
#ifdef NDEBUG
constexpr std::chrono::milliseconds kFirstStatus = 1s;
#else
constexpr std::chrono::milliseconds kFirstStatus = 2s;  // a debug build steps and copies slowly
#endif

std::ptrdiff_t entries_of(const std::filesystem::path& directory) {
  return std::distance(std::filesystem::directory_iterator(directory), {});
}

/// The resources that a service uses.
struct Resources {
  std::ptrdiff_t files = 0;
  std::ptrdiff_t threads = 0;
  std::ptrdiff_t descriptors = 0;
};

class KilledService : public testing::Test {
 protected:
  KilledService()
      : state_(std::filesystem::temp_directory_path() /
               ("vdrive-restart-" + std::to_string(getpid()))) {
    std::filesystem::create_directory(state_);
    setenv("STATE_DIRECTORY", state_.c_str(), 1);
  }

  ~KilledService() override { std::filesystem::remove_all(state_); }

  /// Starts the service and waits until every axis was seen. @return the time that took.
  std::chrono::milliseconds start() {
    probe_ = std::make_unique<Probe>(test_domain());
    std::vector<bool> seen(kAxes);
    const auto begin = Clock::now();
    service_ = std::make_unique<Process>(
        VDRIVE_SERVICE, std::vector<std::string>{"--axes", std::to_string(kAxes), "--log-level",
                                                 "off", "--domain", std::to_string(test_domain())});
    EXPECT_TRUE(probe_->wait_until([&] {
      const auto& frame = probe_->seen_status();
      if (frame) {
        for (const auto& axis : frame->axes) {
          seen[axis.axis - 1U] = true;
          EXPECT_EQ(axis.ds402_statusword & 0x4F, 0x40) << "Switch on disabled";
        }
      }
      return std::ranges::all_of(seen, [](bool axis) {
        return axis;
      });
    }));
    return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin);
  }

  /// Kills the service with an axis enabled, which must be found disabled the next time.
  void kill() {
    ASSERT_TRUE(probe_->find_bench());
    const auto reply = probe_->write(1, 0x6040, 0x0F);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->reason, msg::Reason::none);
    shared_memory_.merge(shared_memory_of(service_->id()));
    service_->send(SIGKILL);
    EXPECT_EQ(service_->wait().code, -SIGKILL);
  }

  /// @return the number of shared-memory files left over by killed services.
  [[nodiscard]] std::ptrdiff_t left_shared_memory() const {
    return std::ranges::count_if(shared_memory_, [](const std::string& file) {
      return std::filesystem::exists(file);
    });
  }

  [[nodiscard]] Resources resources() const {
    const std::filesystem::path process = "/proc/" + std::to_string(service_->id());
    return {.files = entries_of(state_),
            .threads = entries_of(process / "task"),
            .descriptors = entries_of(process / "fd")};
  }

 private:
  std::filesystem::path state_;
  std::set<std::string> shared_memory_;
  std::unique_ptr<Process> service_;
  std::unique_ptr<Probe> probe_;
};

// A single round may coincide with other load on the machine, so the median is judged.
TEST_F(KilledService, RestartsWithinASecondWithDisabledAxesAndLeaksNothing) {
  const int rounds = number_of<int>({.usual = 8, .full = 20, .nightly = 200});
  std::optional<Resources> first;
  std::vector<std::chrono::milliseconds> starts;
  for (int round = 0; round <= rounds; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    starts.push_back(start());
    const Resources now = resources();
    if (!first) first = now;
    EXPECT_EQ(left_shared_memory(), 0);
    EXPECT_EQ(now.files, first->files);
    EXPECT_EQ(now.threads, first->threads);
    EXPECT_LE(now.descriptors, first->descriptors);
    ASSERT_NO_FATAL_FAILURE(kill());
  }
  std::ranges::sort(starts);
  EXPECT_LT(starts[starts.size() / 2], kFirstStatus);
}

}  // namespace
}  // namespace vdrive::test
