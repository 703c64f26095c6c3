// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"
#include "private_domain.hpp"

#include <chrono>
#include <csignal>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::process {

/// A service on a domain that no other program uses, or on the domain of another private bench. It
/// ends with this object.
class PrivateBench {
 public:
  /// @param service path of vdrived
  /// @param arguments further arguments, such as those of its clock
  /// @param domain of the benches that it should find; nothing = one that no other program uses
  /// @throws std::system_error, std::runtime_error
  PrivateBench(const std::string& service, const std::vector<std::string>& arguments,
               std::optional<std::uint32_t> domain = std::nullopt);
  ~PrivateBench();
  PrivateBench(const PrivateBench&) = delete;
  PrivateBench& operator=(const PrivateBench&) = delete;

  [[nodiscard]] std::uint32_t domain() const noexcept { return domain_; }

  /// The highest domain number; the lowest is 0.
  [[nodiscard]] static std::uint32_t highest_domain() noexcept;

  /// Waits until the service is running.
  /// @return why it is not, or nothing.
  [[nodiscard]] std::optional<std::string> wait_until_ready();

  [[nodiscard]] bool has_ended() { return service_.wait(std::chrono::milliseconds(0)).has_value(); }

  /// Ends the service, and with it wait_until_ready(), immediately. Any thread.
  void end() const noexcept { service_.send(SIGTERM); }

 private:
  [[nodiscard]] std::string reason();

  std::optional<PrivateDomain> own_domain_;
  std::uint32_t domain_;
  std::string path_;  ///< of the service
  Descriptor notifications_;
  ChildProcess service_;
};

/// @return the path of the program `name` in this program's directory, otherwise in PATH; nothing
///         if there is none.
[[nodiscard]] std::optional<std::string> find_program(const std::string& name);

/// @return the path of vdrived, found by find_program().
[[nodiscard]] std::optional<std::string> find_service();

/// @return whether `file` exists and is executable.
[[nodiscard]] bool is_program(const std::string& file);

/// @return the path of this program.
[[nodiscard]] std::string own_program();

}  // namespace vdrive::process
