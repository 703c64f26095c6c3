// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/checks.hpp"
#include "gateway_port.hpp"
#include "vdrive/wire/library_version.hpp"
#include "vdrive/wire/ports.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <thread>

namespace vdrive::tool {
namespace {

namespace fs = std::filesystem;

constexpr int kMulticastPatience = 300;  // [ms]

/// The first word of a file; empty if it cannot be read.
std::string first_word(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  stream >> word;
  return word;
}

std::optional<std::uint64_t> first_number(const fs::path& file) {
  std::ifstream stream(file);
  std::uint64_t number = 0;
  if (!(stream >> number)) return std::nullopt;
  return number;
}

/// A socket, closed by the destructor.
class Socket {
 public:
  /// @param type SOCK_DGRAM for UDP, SOCK_STREAM for TCP
  explicit Socket(int type = SOCK_DGRAM) : descriptor_(socket(AF_INET, type, 0)) {}

  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

// NOLINTBEGIN(*-reinterpret-cast): what the socket interface takes
bool receives_multicast(const std::string& own_address) {
  const Socket receiver;
  const Socket sender;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t length = sizeof(address);
  ip_mreq membership{};
  inet_pton(AF_INET, wire::kDiscoveryGroup, &membership.imr_multiaddr);
  inet_pton(AF_INET, own_address.c_str(), &membership.imr_interface);
  if (bind(receiver.get(), reinterpret_cast<const sockaddr*>(&address), length) != 0 ||
      getsockname(receiver.get(), reinterpret_cast<sockaddr*>(&address), &length) != 0 ||
      setsockopt(receiver.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) !=
          0 ||
      setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &membership.imr_interface,
                 sizeof(membership.imr_interface)) != 0) {
    return false;
  }
  address.sin_addr = membership.imr_multiaddr;
  constexpr char kProbe = 'v';
  if (sendto(sender.get(), &kProbe, 1, 0, reinterpret_cast<const sockaddr*>(&address), length) !=
      1) {
    return false;
  }
  pollfd arrival{.fd = receiver.get(), .events = POLLIN, .revents = 0};
  return poll(&arrival, 1, kMulticastPatience) == 1;
}

/// Requests a page from the program that listens on a loopback port.
GatewayReading read_gateway(std::uint16_t port) {
  constexpr std::string_view kRequest =
      "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  const Socket client(SOCK_STREAM);
  const timeval patience{.tv_sec = 0, .tv_usec = kMulticastPatience * 1000L};
  setsockopt(client.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  if (connect(client.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    return GatewayReading::none;
  }
  std::array<char, 512> answer{};
  if (send(client.get(), kRequest.data(), kRequest.size(), MSG_NOSIGNAL) < 0) {
    return GatewayReading::another;
  }
  const ssize_t size = recv(client.get(), answer.data(), answer.size(), 0);
  const std::string_view head(answer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  const bool is_gateway = head.find("Server: vdrive-gateway") != std::string_view::npos;
  return is_gateway ? GatewayReading::gateway : GatewayReading::another;
}

// NOLINTEND(*-reinterpret-cast)

/// Whether a process that we may inspect has mapped the file.
bool is_mapped(const std::string& file) {
  std::error_code ignored;
  for (const auto& process : fs::directory_iterator("/proc", ignored)) {
    const std::string name = process.path().filename();
    if (!std::ranges::all_of(name, [](unsigned char c) {
          return std::isdigit(c) != 0;
        }))
      continue;
    std::ifstream maps(process.path() / "maps");
    for (std::string line; std::getline(maps, line);) {
      if (line.ends_with(file)) return true;
    }
  }
  return false;
}

std::vector<SharedSegment> read_segments() {
  std::vector<SharedSegment> segments;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/dev/shm", ignored)) {
    const std::string name = entry.path().filename();
    const bool is_lock = name.ends_with("_el") || name.ends_with("_sl") || name.starts_with("sem.");
    if (!name.starts_with("fastrtps_") || is_lock) continue;
    segments.push_back({name, is_mapped(entry.path())});
  }
  std::ranges::sort(segments, {}, &SharedSegment::name);
  return segments;
}

std::optional<bool> read_clock_state() {
  timex state{};
  const int result = adjtimex(&state);
  if (result < 0) return std::nullopt;
  return result != TIME_ERROR;
}

std::optional<double> read_load() {
  double load = 0;
  if (getloadavg(&load, 1) != 1) return std::nullopt;
  return load;
}

/// The longest time that the kernel lets a thread wait for a core.
std::chrono::milliseconds longest_delay() {
  // Long enough to be preempted on a busy machine, short enough not to keep the user waiting.
  constexpr int kWaits = 30;
  constexpr std::chrono::milliseconds kWait{1};
  std::chrono::steady_clock::duration longest{};
  for (int wait = 0; wait < kWaits; ++wait) {
    const auto planned = std::chrono::steady_clock::now() + kWait;
    std::this_thread::sleep_until(planned);
    longest = std::max(longest, std::chrono::steady_clock::now() - planned);
  }
  return std::chrono::floor<std::chrono::milliseconds>(longest);
}

bool may_run_realtime() {
  bool permitted = false;
  std::thread([&permitted] {  // the priority ends with the thread
    const sched_param priority{.sched_priority = 1};
    permitted = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  })
      .join();
  return permitted;
}

}  // namespace

HostReadings read_host(const std::vector<std::string>& interfaces) {
  HostReadings readings;
  readings.library = wire::library_version();
  readings.interfaces = wire::own_interfaces();
  for (const std::string& interface :
       interfaces.empty() ? std::vector<std::string>{"127.0.0.1"} : interfaces) {
    for (const std::string& address : wire::addresses_of(interface, readings.interfaces)) {
      readings.multicast.push_back({address, receives_multicast(address)});
    }
  }
  readings.segments = read_segments();
  readings.is_clock_synchronised = read_clock_state();
  readings.clock_source =
      first_word("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  readings.largest_receive_buffer = first_number("/proc/sys/net/core/rmem_max");
  readings.first_ephemeral_port = first_number("/proc/sys/net/ipv4/ip_local_port_range");
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) == 0) readings.open_files = files.rlim_cur;
  readings.cores = std::thread::hardware_concurrency();
  readings.load = read_load();
  readings.longest_delay = longest_delay();
  readings.may_run_realtime = may_run_realtime();
  readings.gateway = read_gateway(bridge::kGatewayPort);
  return readings;
}

}  // namespace vdrive::tool
