// SPDX-License-Identifier: Apache-2.0
#include "supervision/wire_spawner.hpp"

#include "base/system_failure.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

namespace vdrive::service {
namespace {

using Order = WireSpawner::Order;

/// The descriptor under which a wire finds the region.
constexpr int kRegionOfWire = 3;

/// The status of exit code 127, as waitpid returns it: the kernel could not fork.
constexpr int kNotStarted = 127 << 8;

/// How long the engine waits for the end of the spawner, and the spawner for the end of the wire.
constexpr std::chrono::milliseconds kLongestEnd{100};

/// The interval between attempts to reap processes that were reported while they were dying.
constexpr std::chrono::milliseconds kReapInterval{100};

/// A process as /proc/PID/stat shows it; the members are fields of proc(5).
struct ProcessState {
  char state = 0;
  unsigned long flags = 0;
  int exit_code = 0;  ///< as waitpid returns it; for a stopped process, the signal
};

std::optional<ProcessState> state_of(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::size_t name_end = text.rfind(')');  // the name may contain anything
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(name_end + 1));
  ProcessState seen;
  std::string skipped;
  fields >> seen.state;
  for (int field = 4; field < 9; ++field) fields >> skipped;
  fields >> seen.flags;
  for (int field = 10; field < 52; ++field) fields >> skipped;
  fields >> seen.exit_code;
  return seen;
}

/// @return the exit status of a process that executes no instruction any more but cannot be reaped
///         yet: freeing memory, writing a core or a debugger can keep it in the kernel for seconds.
///         nullopt for any other process.
std::optional<int> status_of_dying(pid_t process) {
  constexpr unsigned long kExiting = 0x4;  // PF_EXITING of the kernel
  const auto seen = state_of(process);
  if (!seen) return std::nullopt;
  const int code = seen->exit_code;
  const bool is_stop = code == SIGSTOP || code == SIGTSTP || code == SIGTTIN || code == SIGTTOU;
  const bool is_dying = seen->state == 'Z' || seen->state == 'X' || (seen->flags & kExiting) != 0 ||
                        (code != 0 && !is_stop);
  return is_dying ? std::optional(is_stop ? 0 : code) : std::nullopt;
}

// NOLINTBEGIN(*-vararg): the kernel's interface is C

/// Waits for the process of a pidfd to end, for kLongestEnd at most.
void await_end(int descriptor) {
  pollfd ended{.fd = descriptor, .events = POLLIN, .revents = 0};
  static_cast<void>(poll(&ended, 1, static_cast<int>(kLongestEnd.count())));
}

[[noreturn]] void become_wire(int region, pid_t spawner) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);      // no wire without a spawner
  if (getppid() != spawner) _exit(127);  // the spawner was killed between the fork and prctl
  const int descriptor = region == kRegionOfWire ? region : dup2(region, kRegionOfWire);
  fcntl(descriptor, F_SETFD, 0);
  close_range(kRegionOfWire + 1, ~0U, 0);
  sigset_t none;
  sigemptyset(&none);
  pthread_sigmask(SIG_SETMASK, &none, nullptr);
  // A terminal or a service manager sends its signal to all processes; the engine decides when the
  // wire ends.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  execl("/proc/self/exe", "vdrived", "--wire-process", "3", nullptr);
  _exit(127);
}

/// The main loop of the spawner's process: forks and kills wires as ordered.
class ForkServer {
 public:
  ForkServer(int socket, int region) : socket_(socket), region_(region) {}

  [[noreturn]] void run() {
    while (true) {
      std::array<pollfd, 2> watched{{{.fd = socket_, .events = POLLIN, .revents = 0},
                                     {.fd = child_descriptor_, .events = POLLIN, .revents = 0}}};
      const int timeout = leaving_.empty() ? -1 : static_cast<int>(kReapInterval.count());
      if (poll(watched.data(), watched.size(), timeout) < 0 && errno != EINTR) leave();
      std::erase_if(leaving_, [](pid_t process) {
        return waitpid(process, nullptr, WNOHANG) != 0;
      });
      if (watched[1].revents != 0) examine();
      if (watched[0].revents != 0) obey();
    }
  }

 private:
  void obey() {
    Order order{};
    const ssize_t size = recv(socket_, &order, sizeof order, 0);
    if (size <= 0) {
      leave();  // the engine is gone
    }
    if (order == Order::launch && child_ == 0) {
      start();
    } else if (order == Order::examine && child_ > 0) {
      examine();
    } else if (order == Order::kill && child_ > 0) {
      ::kill(child_, SIGKILL);
    }
  }

  void start() {
    const pid_t spawner = getpid();
    child_ = fork();
    if (child_ == 0) become_wire(region_, spawner);
    if (child_ < 0) {
      child_ = 0;
      send_end({.process = 0, .status = kNotStarted});
      return;
    }
    child_descriptor_ = static_cast<int>(syscall(SYS_pidfd_open, child_, 0));
    if (child_descriptor_ < 0) {  // without a pidfd only an examination would notice its end
      ::kill(child_, SIGKILL);
      leaving_.push_back(child_);
      report_end(SIGKILL);
    }
  }

  /// Reports the end of the wire if it has ended or is dying.
  void examine() {
    int status = 0;
    const pid_t reaped = waitpid(child_, &status, WNOHANG);
    if (reaped != 0) {
      report_end(status);
    } else if (const auto dying = status_of_dying(child_)) {
      leaving_.push_back(child_);
      report_end(*dying);
    }
  }

  void report_end(int status) {
    const WireEnd end{.process = child_, .status = status};
    if (child_descriptor_ >= 0) close(child_descriptor_);
    child_ = 0;
    child_descriptor_ = -1;
    send_end(end);
  }

  void send_end(const WireEnd& end) const {
    static_cast<void>(send(socket_, &end, sizeof end, MSG_NOSIGNAL));
  }

  [[noreturn]] void leave() const {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      await_end(child_descriptor_);
    }
    _exit(0);
  }

  int socket_;
  int region_;
  pid_t child_ = 0;
  int child_descriptor_ = -1;
  std::vector<pid_t> leaving_;  ///< reported but not reaped yet
};

// NOLINTEND(*-vararg)

}  // namespace

WireSpawner::WireSpawner(int region) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    fail("starting the spawner of the network process");
  }
  const pid_t engine = getpid();
  process_ = fork();
  if (process_ < 0) fail("starting the spawner of the network process");
  if (process_ == 0) {
    // A stopped spawner would not notice that the engine is gone.
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // NOLINT(*-vararg)
    if (getppid() != engine) _exit(0);
    close(ends[0]);
    prctl(PR_SET_NAME, "vdrived-spawner");  // NOLINT(*-vararg)
    std::signal(SIGINT, SIG_IGN);
    std::signal(SIGTERM, SIG_IGN);
    std::signal(SIGCHLD, SIG_DFL);  // if it were ignored, the kernel would keep no exit status
    ForkServer(ends[1], region).run();
  }
  close(ends[1]);
  socket_ = ends[0];
  descriptor_ = static_cast<int>(syscall(SYS_pidfd_open, process_, 0));  // NOLINT(*-vararg)
  if (descriptor_ < 0) fail("starting the spawner of the network process");
}

WireSpawner::~WireSpawner() {
  close(socket_);
  // A stopped spawner does not end now; the kernel kills it when the engine ends.
  await_end(descriptor_);
  waitpid(process_, nullptr, WNOHANG);
  close(descriptor_);
}

bool WireSpawner::launch() noexcept {
  is_gone_ = !order(Order::launch);
  return !is_gone_;
}

void WireSpawner::examine() const noexcept {
  order(Order::examine);
}

void WireSpawner::kill() const noexcept {
  order(Order::kill);
}

/// Does not wait: the socket of a stopped spawner has room for several hundred orders.
bool WireSpawner::order(Order order) const noexcept {
  return send(socket_, &order, sizeof order, MSG_NOSIGNAL | MSG_DONTWAIT) == sizeof order;
}

std::optional<WireEnd> WireSpawner::next_end() noexcept {
  WireEnd end;
  const ssize_t size = recv(socket_, &end, sizeof end, MSG_DONTWAIT);
  is_gone_ = size == 0 || (size < 0 && errno == ECONNRESET);
  return size == sizeof end ? std::optional(end) : std::nullopt;
}

}  // namespace vdrive::service
