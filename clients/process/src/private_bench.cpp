// SPDX-License-Identifier: Apache-2.0
#include "private_bench.hpp"

#include "vdrive/wire/ports.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

namespace vdrive::process {
namespace {

using Clock = std::chrono::steady_clock;

// Generous, because a busy machine may start many services at the same time.
constexpr std::chrono::seconds kStart{60};
constexpr std::chrono::seconds kEnd{5};

/// A notification socket like that of a service manager, with a name chosen by the system.
int open_notifications() {
  const int receiver = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
  if (bind(receiver, reinterpret_cast<const sockaddr*>(&address), sizeof address.sun_family) != 0) {
    throw std::system_error(errno, std::generic_category(), "socket for notifications");
  }
  return receiver;
}

/// @return NOTIFY_SOCKET=@name.
std::string variable_of(int receiver) {
  sockaddr_un address{};
  socklen_t length = sizeof address;
  // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
  if (getsockname(receiver, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    throw std::system_error(errno, std::generic_category(), "socket for notifications");
  }
  // The name starts with a zero byte, which the variable represents as @.
  const std::string_view path(&address.sun_path[0], length - offsetof(sockaddr_un, sun_path));
  return "NOTIFY_SOCKET=@" + std::string(path.substr(1));
}

std::vector<std::string> command_of(const std::string& service, std::uint32_t domain,
                                    const std::vector<std::string>& arguments) {
  std::vector<std::string> command{service, "--domain", std::to_string(domain), "--log-level",
                                   "error"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

std::string without_line_end(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace

PrivateBench::PrivateBench(const std::string& service, const std::vector<std::string>& arguments,
                           std::optional<std::uint32_t> domain)
    : own_domain_(domain ? std::nullopt : std::make_optional<PrivateDomain>()),
      domain_(domain ? *domain : own_domain_->number()),
      path_(service),
      notifications_(open_notifications()),
      service_(command_of(service, domain_, arguments),
               // Variables that a service manager set for this program are not meant for the
               // service.
               {variable_of(notifications_.get()), "WATCHDOG_USEC", "STATE_DIRECTORY"}) {}

std::uint32_t PrivateBench::highest_domain() noexcept {
  return wire::kHighestDomain;
}

PrivateBench::~PrivateBench() {
  service_.stop(kEnd);
}

std::optional<std::string> PrivateBench::wait_until_ready() {
  const auto deadline = Clock::now() + kStart;
  std::array<pollfd, 2> news{pollfd{notifications_.get(), POLLIN, 0},
                             pollfd{service_.descriptor(), POLLIN, 0}};
  while (Clock::now() < deadline) {
    if (poll(news.data(), news.size(), 100) <= 0) continue;
    std::array<char, 1024> text{};
    const ssize_t length = recv(notifications_.get(), text.data(), text.size(), MSG_DONTWAIT);
    const bool is_ready =
        length > 0 &&
        std::string_view(text.data(), static_cast<std::size_t>(length)).starts_with("READY=1");
    if (is_ready) return std::nullopt;
    if (news[1].revents != 0) {
      return "the service did not start: " + reason();
    }
  }
  return "the service did not start in time";
}

/// The error output of the service, or how it ended without any.
std::string PrivateBench::reason() {
  std::string errors = without_line_end(service_.errors());
  if (!errors.empty()) return errors;
  if (!std::filesystem::exists(path_)) return path_ + ": no such file";
  if (!is_program(path_)) return path_ + ": not a program that can be executed";
  const int code = service_.wait().value_or(0);
  return path_ +
         (code < 0 ? " was ended by signal " + std::to_string(-code)
                   : " ended with exit code " + std::to_string(code)) +
         " and wrote nothing";
}

std::string own_program() {
  return std::filesystem::read_symlink("/proc/self/exe").string();
}

bool is_program(const std::string& file) {
  return access(file.c_str(), X_OK) == 0 && !std::filesystem::is_directory(file);
}

std::optional<std::string> find_program(const std::string& name) {
  const std::filesystem::path beside = std::filesystem::path(own_program()).parent_path() / name;
  if (is_program(beside)) return beside.string();
  const char* const path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): one thread yet
  std::istringstream directories(path == nullptr ? "" : path);
  for (std::string directory; std::getline(directories, directory, ':');) {
    const std::filesystem::path found = std::filesystem::path(directory) / name;
    if (is_program(found)) return std::filesystem::absolute(found).string();
  }
  return std::nullopt;
}

std::optional<std::string> find_service() {
  return find_program("vdrived");
}

}  // namespace vdrive::process
