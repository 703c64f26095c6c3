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

/// The status of exit code 127, as waitpid returns it: the kernel gave no process.
constexpr int kNotStarted = 127 << 8;

/// How long either side waits for the process below it, which has been told to end.
constexpr std::chrono::milliseconds kLongestEnd{100};

/// Between two examinations of processes that are not reaped yet.
constexpr std::chrono::milliseconds kReapInterval{100};

/// A process as /proc/PID/stat shows it; the members are fields of proc(5).
struct ProcessState {
  char state = 0;
  unsigned long flags = 0;
  int exit_code = 0;  ///< as waitpid returns it; of a stopped process its signal
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

/// @return how a process ends that runs no instruction of its program any more, although it cannot
///         be reaped yet: memory that is given back, a core that is written or a debugger can hold
///         it in the kernel for seconds.
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

/// Waits until the process behind a descriptor has ended, or no longer.
void await_end(int descriptor) {
  pollfd ended{.fd = descriptor, .events = POLLIN, .revents = 0};
  static_cast<void>(poll(&ended, 1, static_cast<int>(kLongestEnd.count())));
}

[[noreturn]] void become_wire(int region, pid_t spawner) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);      // no wire without a spawner
  if (getppid() != spawner) _exit(127);  // it was killed between the fork and that call
  const int descriptor = region == kRegionOfWire ? region : dup2(region, kRegionOfWire);
  fcntl(descriptor, F_SETFD, 0);
  close_range(kRegionOfWire + 1, ~0U, 0);
  sigset_t none;
  sigemptyset(&none);
  pthread_sigmask(SIG_SETMASK, &none, nullptr);
  // An interrupt of a terminal or of a service manager goes to all processes: the engine decides.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  execl("/proc/self/exe", "vdrived", "--wire-process", "3", nullptr);
  _exit(127);
}

/// What runs in the spawner's process: it forks wires as it is told.
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
      leave();  // the engine has gone
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
    if (child_descriptor_ < 0) {  // only an examination would notice its end
      ::kill(child_, SIGKILL);
      leaving_.push_back(child_);
      report_end(SIGKILL);
    }
  }

  /// Reports the wire's end where it has ended, or can do nothing else.
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
  std::vector<pid_t> leaving_;  ///< reported, and not reaped yet
};

// NOLINTEND(*-vararg)

}  // namespace

WireSpawner::WireSpawner(int region) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    fail("start of the wire's process");
  }
  const pid_t engine = getpid();
  process_ = fork();
  if (process_ < 0) fail("start of the wire's process");
  if (process_ == 0) {
    // A stopped spawner would not see that the engine has gone.
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // NOLINT(*-vararg)
    if (getppid() != engine) _exit(0);
    close(ends[0]);
    prctl(PR_SET_NAME, "vdrived-spawner");  // NOLINT(*-vararg)
    std::signal(SIGINT, SIG_IGN);
    std::signal(SIGTERM, SIG_IGN);
    std::signal(SIGCHLD, SIG_DFL);  // where it is ignored, the kernel keeps no status for waitpid
    ForkServer(ends[1], region).run();
  }
  close(ends[1]);
  socket_ = ends[0];
  descriptor_ = static_cast<int>(syscall(SYS_pidfd_open, process_, 0));  // NOLINT(*-vararg)
  if (descriptor_ < 0) fail("start of the wire's process");
}

WireSpawner::~WireSpawner() {
  close(socket_);
  // A spawner that is stopped does not end now: the kernel kills it together with the engine.
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

/// A spawner that does not run has room for several hundred orders; none is waited for.
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
