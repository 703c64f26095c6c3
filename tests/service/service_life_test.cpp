// SPDX-License-Identifier: Apache-2.0
// The life of vdrived: its messages to the service manager, how its axes come to rest before it
// ends, and how it restarts after any failure.
#include "service/probe.hpp"
#include "support/deadline.hpp"
#include "support/process_tree.hpp"
#include "support/signals.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gtest/gtest.h>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::uint16_t kStateMask = 0x6F;
constexpr std::uint16_t kOperationEnabled = 0x27;
constexpr std::uint16_t kSwitchOnDisabledMask = 0x4F;
constexpr std::uint16_t kSwitchOnDisabled = 0x40;

/// An environment variable that child processes see while this object lives.
class EnvironmentVariable {
 public:
  EnvironmentVariable(std::string name, const std::string& value) : name_(std::move(name)) {
    setenv(name_.c_str(), value.c_str(), 1);
  }

  ~EnvironmentVariable() { unsetenv(name_.c_str()); }

  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  std::string name_;
};

/// The receiving socket of a service manager. Child processes find it in NOTIFY_SOCKET; after it is
/// destroyed none may, because the next socket may have the same name.
class NotifySocket {
 public:
  NotifySocket() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const std::string name = name_of_process();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(name.begin(), name.end(), &address.sun_path[1]);  // abstract: leaves no file
    const auto size = offsetof(sockaddr_un, sun_path) + 1 + name.size();
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&address),  // NOLINT(*-reinterpret-cast)
             static_cast<socklen_t>(size)) != 0) {
      throw std::runtime_error("no notify socket");
    }
  }

  ~NotifySocket() { close(socket_); }

  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  /// @return the next message, or nothing if none arrives in that time
  std::optional<std::string> next(std::chrono::milliseconds patience = Probe::kPatience) {
    pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&readable, 1, static_cast<int>(patience.count())) != 1) return std::nullopt;
    std::array<char, 1024> text{};
    const ssize_t size = recv(socket_, text.data(), text.size(), 0);
    return std::string(text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  }

  /// Reads messages until one has that line. @return false if none arrives within
  /// `Probe::kPatience`.
  bool wait_for(std::string_view line) {
    while (const auto message = next()) {
      if (("\n" + *message + "\n").find("\n" + std::string(line) + "\n") != std::string::npos) {
        return true;
      }
    }
    report_missed_deadline("there was no message of the service", Probe::kPatience);
    return false;
  }

 private:
  static std::string name_of_process() { return "vdrive-test-" + std::to_string(getpid()); }

  int socket_;
  EnvironmentVariable variable_{"NOTIFY_SOCKET", "@" + name_of_process()};
};

std::unique_ptr<Process> serve(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--log-level", "off", "--domain",  //
                                     std::to_string(test_domain())});
  return std::make_unique<Process>(VDRIVE_SERVICE, std::move(arguments));
}

/// A configuration file, removed in the destructor, whose bench has no watchdog.
class BenchFile {
 public:
  BenchFile()
      : path_(std::filesystem::temp_directory_path() /
              ("vdrive-life-" + std::to_string(getpid()) + ".yaml")) {
    std::ofstream(path_) << "watchdog: {timeout_ms: off}\n";
  }

  ~BenchFile() { std::filesystem::remove(path_); }

  BenchFile(const BenchFile&) = delete;
  BenchFile& operator=(const BenchFile&) = delete;

  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// A motion in profile position mode.
struct Motion {
  std::uint32_t velocity = 40'000;      ///< [UU/s]
  std::uint32_t deceleration = 80'000;  ///< [UU/s2], 6084h and 6085h: half a second to stop
};

/// @return a frame for the axes `first` to `last`, with `controlword` only.
msg::CommandFrame words_for(Probe& probe, std::uint16_t first, std::uint16_t last,
                            std::uint16_t controlword) {
  msg::CommandFrame frame = probe.make_frame();
  for (std::uint16_t axis = first; axis <= last; ++axis) {
    auto& command = frame.axes.emplace_back();
    command.axis = axis;
    command.members = msg::HAS_DS402_CONTROLWORD;
    command.ds402_controlword = controlword;
  }
  return frame;
}

void add_motion(const Motion& motion, msg::CommandFrame& frame) {
  for (auto& command : frame.axes) {
    command.members = msg::HAS_DS402_CONTROLWORD | msg::HAS_OP_MODE_CMD |
                      msg::HAS_POSITION_USER_TARGET_VALUE | msg::HAS_PROFILE_VELOCITY |
                      msg::HAS_PROFILE_ACC | msg::HAS_PROFILE_DEC;
    command.op_mode_cmd = 1;
    command.position_user_target_value = 2'000'000'000;
    command.profile_velocity = motion.velocity;
    command.profile_acc = 4'000'000;
    command.profile_dec = motion.deceleration;
    auto& quick_stop = command.objects.emplace_back();
    quick_stop.index = 0x6085;
    quick_stop.subindex = 0;
    quick_stop.value = motion.deceleration;
  }
}

/// Enables axes 1 to `count` and starts their motion.
void start_all(Probe& probe, std::uint16_t count, const Motion& motion) {
  std::vector<std::uint16_t> axes;
  for (std::uint16_t axis = 1; axis <= count; ++axis) axes.push_back(axis);
  for (std::size_t first = 0; first < axes.size(); first += msg::MAX_AXES_PER_FRAME) {
    const auto last = std::min(axes.size(), first + msg::MAX_AXES_PER_FRAME);
    const std::vector<std::uint16_t> part(axes.begin() + static_cast<std::ptrdiff_t>(first),
                                          axes.begin() + static_cast<std::ptrdiff_t>(last));
    ASSERT_TRUE(probe.acquire(part));
  }
  for (const std::uint16_t word : std::array<std::uint16_t, 2>{0x0F, 0x1F}) {
    for (std::uint16_t first = 1; first <= count; first += msg::MAX_AXES_PER_FRAME) {
      const auto last =
          static_cast<std::uint16_t>(std::min<int>(count, first + msg::MAX_AXES_PER_FRAME - 1));
      auto frame = words_for(probe, first, last, word);
      if (word == 0x0F) add_motion(motion, frame);
      frame.flags = msg::FRAME_WANT_REPLY;
      ASSERT_TRUE(probe.send(frame));
      const auto reply = probe.reply_to(frame.sequence_number);
      ASSERT_TRUE(reply);
      ASSERT_TRUE(reply->refusals.empty());
    }
  }
}

/// The latest status of each axis (at its number less 1), and every status of the first.
class Watched {
 public:
  /// For use inside a condition of `Probe::wait_until`. @return whether the frame is new.
  bool observe(const Probe& probe) {
    const auto& frame = probe.seen_status();
    if (!frame || (frame->tick == tick_ && frame->part == part_)) return false;
    tick_ = frame->tick;
    part_ = frame->part;
    for (const auto& axis : frame->axes) {
      last_.resize(std::max<std::size_t>(last_.size(), axis.axis));
      last_[axis.axis - 1U] = axis;
    }
    if (part_ == 0) first_axis_.push_back(frame->axes.front());
    return true;
  }

  [[nodiscard]] std::size_t size() const { return last_.size(); }

  template <typename Condition>
  [[nodiscard]] bool all(Condition condition) const {
    return !last_.empty() && std::all_of(last_.begin(), last_.end(), condition);
  }

  [[nodiscard]] const std::vector<msg::AxisStatus>& first_axis() const { return first_axis_; }

 private:
  std::uint64_t tick_ = 0;
  std::uint16_t part_ = 0;
  std::vector<msg::AxisStatus> last_;
  std::vector<msg::AxisStatus> first_axis_;
};

bool is_switch_on_disabled(const msg::AxisStatus& status) {
  return (status.ds402_statusword & kSwitchOnDisabledMask) == kSwitchOnDisabled;
}

/// The last status and the offline announcement are samples of two topics and may arrive in either
/// order.
/// @return whether all axes were seen switched off.
bool sees_switched_off(Probe& probe, Watched& watched) {
  return probe.wait_until([&] {
    watched.observe(probe);
    return watched.all(is_switch_on_disabled);
  });
}

/// Sends SIGTERM, follows the status until the bench is offline, and waits for the process to end.
void terminate(Process& service, Probe& probe, Watched& watched) {
  const auto begin = Clock::now();
  service.send(SIGTERM);
  EXPECT_TRUE(probe.wait_until([&] {
    watched.observe(probe);
    return probe.seen_offline();
  }));
  EXPECT_EQ(service.wait().code, 0);
  EXPECT_LT(Clock::now() - begin, 2s);
}

TEST(ServiceManager, IsNotifiedAfterTheServiceHasCheckedItsBenchNumber) {
  NotifySocket socket;
  const auto begin = Clock::now();
  const auto service = serve({"--bench", "3"});
  const auto message = socket.next();
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, "READY=1\nSTATUS=bench 3, 2 axes, realtime, DDS domain " +
                          std::to_string(test_domain()));
  EXPECT_GE(Clock::now() - begin, 300ms) << "the announcement is preceded by 300 ms of silence";
  Probe probe(test_domain(), 3);
  EXPECT_TRUE(probe.find_bench());
  service->send(SIGTERM);
  EXPECT_TRUE(socket.wait_for("STOPPING=1"));
  EXPECT_EQ(service->wait().code, 0);
}

TEST(ServiceManager, IsNotifiedOfTheLossAndReturnOfTheNetworkProcess) {
  NotifySocket socket;
  const auto service = serve({"--wire", "process"});
  const std::string good = "STATUS=bench 1, 2 axes, realtime, DDS domain " +  //
                           std::to_string(test_domain());
  ASSERT_TRUE(socket.wait_for(good));
  const pid_t spawner = child_of(service->id());
  ASSERT_NE(spawner, 0);
  // The first wire to end is replaced immediately, before the program checks again after 50 ms.
  // Each further one is replaced after twice the time: 100 ms, 200 ms...
  std::optional<std::string> message;
  const auto deadline = Clock::now() + 10s;
  while (!message && Clock::now() < deadline) {
    if (const pid_t wire = child_of(spawner); wire != 0) send_signal(wire, SIGKILL);
    message = socket.next(20ms);
  }
  EXPECT_EQ(message, good + ", no network: the network process is down");
  EXPECT_EQ(socket.next(), good);
  service->send(SIGTERM);
  EXPECT_EQ(service->wait().code, 0);
}

// A service that cannot start a network process ends with the exit code of a failure, so the
// service manager starts it again.
TEST(ServiceManager, RestartsAServiceThatCannotStartANetworkProcess) {
  NotifySocket socket;
  const auto service = serve({"--wire", "process"});
  ASSERT_TRUE(socket.wait_for("READY=1"));
  const pid_t spawner = child_of(service->id());
  ASSERT_NE(spawner, 0);
  send_signal(spawner, SIGKILL);
  EXPECT_TRUE(socket.wait_for("STOPPING=1"));
  const Finished finished = service->wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_NE(finished.errors.find("the process that starts the network process has ended"),
            std::string::npos)
      << finished.errors;
}

TEST(ServiceManager, IsNotNotifiedByAServiceWhoseBenchNumberIsInUse) {
  const auto first = serve({"--bench", "3"});
  Probe probe(test_domain(), 3);
  ASSERT_TRUE(probe.find_bench());
  NotifySocket socket;
  const auto second = serve({"--bench", "3"});
  EXPECT_EQ(second->wait().code, 5);
  EXPECT_EQ(socket.next(0ms), std::nullopt);
}

class SupervisedService : public testing::TestWithParam<std::vector<std::string>> {};

TEST_P(SupervisedService, SendsWatchdogMessagesOnlyWhileItRuns) {
  NotifySocket socket;
  const EnvironmentVariable watchdog("WATCHDOG_USEC", "400000");
  const auto service = serve(GetParam());
  ASSERT_TRUE(socket.wait_for("READY=1"));
  for (int beat = 0; beat < 3; ++beat) EXPECT_EQ(socket.next(), "WATCHDOG=1");
  service->send(SIGSTOP);
  while (socket.next(50ms)) {  // messages still on their way
  }
  EXPECT_EQ(socket.next(1s), std::nullopt) << "five intervals of 200 ms";
  service->send(SIGCONT);
  EXPECT_EQ(socket.next(), "WATCHDOG=1");
  service->send(SIGTERM);
  EXPECT_TRUE(socket.wait_for("STOPPING=1"));
}

INSTANTIATE_TEST_SUITE_P(Clocks, SupervisedService,
                         testing::Values(std::vector<std::string>{},
                                         std::vector<std::string>{"--rate", "0"},
                                         std::vector<std::string>{"--clock", "lockstep"},
                                         std::vector<std::string>{"--clock", "freerun"}),
                         [](const auto& arguments) {
                           return arguments.param.empty()     ? "realtime"
                                  : arguments.param[1] == "0" ? "paused"
                                                              : arguments.param[1];
                         });

TEST(TerminatedService, BrakesItsAxesOnTheirRampAndDisablesThem) {
  const BenchFile file;
  const auto service = serve({"--config", file.path()});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_NO_FATAL_FAILURE(start_all(probe, 2, {}));
  Watched watched;
  ASSERT_TRUE(probe.wait_until([&] {
    return watched.observe(probe) && watched.first_axis().back().velocity_demand_value == 40'000;
  }));
  const std::size_t begin = watched.first_axis().size();
  terminate(*service, probe, watched);
  const auto& seen = watched.first_axis();
  // 40 000 UU/s at 80 000 UU/s2 take 500 ticks, none faster than the previous one.
  std::size_t braking = 0;
  for (std::size_t sample = begin; sample < seen.size(); ++sample) {
    const auto speed = seen[sample].velocity_demand_value;
    EXPECT_LE(speed, seen[sample - 1].velocity_demand_value);
    braking += speed > 0 && speed < 40'000 ? 1 : 0;
  }
  EXPECT_GT(braking, 250U) << "samples on the ramp; some of the 500 may get lost";
  EXPECT_TRUE(sees_switched_off(probe, watched));
}

TEST(TerminatedService, WithAThousandMovingAxesEndsWithinTwoSeconds) {
  const BenchFile file;
  const auto service = serve({"--config", file.path(), "--axes", "1000"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_NO_FATAL_FAILURE(start_all(probe, 1'000, {.deceleration = 4'000}));  // 10 s to rest
  Watched watched;
  ASSERT_TRUE(probe.wait_until([&] {
    watched.observe(probe);
    return watched.size() == 1'000 && watched.all([](const auto& status) {
      return (status.ds402_statusword & kStateMask) == kOperationEnabled;
    });
  }));
  terminate(*service, probe, watched);
}

TEST(TerminatedService, RefusesCommandsWhileItsAxesBrake) {
  const BenchFile file;
  const auto service = serve({"--config", file.path()});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_NO_FATAL_FAILURE(start_all(probe, 1, {.deceleration = 4'000}));
  service->send(SIGTERM);
  ASSERT_TRUE(probe.event([](const auto& event) {
    return event.kind == msg::EventKind::shutdown;
  }));
  const auto reply = probe.write(1, 0x6040, 0x1F);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->reason, msg::Reason::shutting_down);
  EXPECT_EQ(service->wait().code, 0);
}

TEST(TerminatedService, EndsAtOnceAfterASecondSignal) {
  const BenchFile file;
  const auto service = serve({"--config", file.path()});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_NO_FATAL_FAILURE(start_all(probe, 1, {.deceleration = 4'000}));
  Watched watched;
  service->send(SIGTERM);
  ASSERT_TRUE(probe.event([](const auto& event) {
    return event.kind == msg::EventKind::shutdown;
  }));
  service->send(SIGINT);
  ASSERT_TRUE(probe.wait_until([&] {
    watched.observe(probe);
    return probe.seen_offline();
  }));
  EXPECT_EQ(service->wait().code, 0);
  EXPECT_TRUE(std::ranges::none_of(watched.first_axis(), [](const auto& status) {
    return (status.ds402_statusword & kStateMask) == 0x07;
  })) << "no quick stop after a second: the power is gone before";
}

class TerminatedAtRest : public testing::TestWithParam<std::vector<std::string>> {};

TEST_P(TerminatedAtRest, DisablesItsAxesWhereTimeStandsStill) {
  const BenchFile file;
  auto arguments = GetParam();
  arguments.insert(arguments.end(), {"--config", file.path()});
  const auto service = serve(arguments);
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const auto reply = probe.write(1, 0x6040, 0x0F);
  ASSERT_TRUE(reply);
  ASSERT_EQ(reply->reason, msg::Reason::none);
  Watched watched;
  terminate(*service, probe, watched);
  EXPECT_TRUE(probe.wait_until([&] {
    watched.observe(probe);
    return !watched.first_axis().empty() && watched.first_axis().back().tick == reply->tick;
  })) << "the tick in which the command would have been in force is the last one";
  EXPECT_TRUE(sees_switched_off(probe, watched));
}

INSTANTIATE_TEST_SUITE_P(Clocks, TerminatedAtRest,
                         testing::Values(std::vector<std::string>{"--rate", "0"},
                                         std::vector<std::string>{"--clock", "lockstep"}),
                         [](const auto& arguments) {
                           return arguments.param[1] == "0" ? "paused" : "lockstep";
                         });

}  // namespace
}  // namespace vdrive::test
