// SPDX-License-Identifier: Apache-2.0
#include "wire_spawner.hpp"

#include "system_failure.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

namespace vdrive::service {
namespace {

enum class Order : std::uint8_t { launch, kill };

/// The descriptor under which a wire finds the region.
constexpr int kRegionOfWire = 3;

/// The status of exit code 127, as waitpid returns it: the kernel gave no process.
constexpr int kNotStarted = 127 << 8;

// NOLINTBEGIN(*-vararg): the kernel's interface is C

[[noreturn]] void become_wire(int region) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // no wire without a spawner
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

/// The spawner's own process.
class Nursery {
 public:
  Nursery(int socket, int region) : socket_(socket), region_(region) {}

  [[noreturn]] void run() {
    while (true) {
      std::array<pollfd, 2> watched{{{.fd = socket_, .events = POLLIN, .revents = 0},
                                     {.fd = child_descriptor_, .events = POLLIN, .revents = 0}}};
      if (poll(watched.data(), watched.size(), -1) < 0 && errno != EINTR) leave();
      if (watched[1].revents != 0) report_end();
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
      child_ = fork();
      if (child_ == 0) become_wire(region_);
      if (child_ < 0) {
        child_ = 0;
        send_end({.process = 0, .status = kNotStarted});
        return;
      }
      child_descriptor_ = static_cast<int>(syscall(SYS_pidfd_open, child_, 0));
      if (child_descriptor_ < 0) {  // its end could not be noticed
        ::kill(child_, SIGKILL);
        report_end();
      }
    } else if (order == Order::kill && child_ > 0) {
      ::kill(child_, SIGKILL);
    }
  }

  void report_end() {
    WireEnd end{.process = child_};
    waitpid(child_, &end.status, 0);
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
      waitpid(child_, nullptr, 0);
    }
    _exit(0);
  }

  int socket_;
  int region_;
  pid_t child_ = 0;
  int child_descriptor_ = -1;
};

// NOLINTEND(*-vararg)

}  // namespace

WireSpawner::WireSpawner(int region) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    fail("start of the wire's process");
  }
  process_ = fork();
  if (process_ < 0) fail("start of the wire's process");
  if (process_ == 0) {
    close(ends[0]);
    prctl(PR_SET_NAME, "vdrived-spawner");  // NOLINT(*-vararg)
    std::signal(SIGINT, SIG_IGN);
    std::signal(SIGTERM, SIG_IGN);
    Nursery(ends[1], region).run();
  }
  close(ends[1]);
  socket_ = ends[0];
}

WireSpawner::~WireSpawner() {
  close(socket_);
  waitpid(process_, nullptr, 0);
}

bool WireSpawner::launch() noexcept {
  const Order order = Order::launch;
  is_gone_ = send(socket_, &order, sizeof order, MSG_NOSIGNAL) != sizeof order;
  return !is_gone_;
}

void WireSpawner::kill() const noexcept {
  const Order order = Order::kill;
  static_cast<void>(send(socket_, &order, sizeof order, MSG_NOSIGNAL));
}

std::optional<WireEnd> WireSpawner::next_end() noexcept {
  WireEnd end;
  const ssize_t size = recv(socket_, &end, sizeof end, MSG_DONTWAIT);
  is_gone_ = size == 0 || (size < 0 && errno == ECONNRESET);
  return size == sizeof end ? std::optional(end) : std::nullopt;
}

}  // namespace vdrive::service
