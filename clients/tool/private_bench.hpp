// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"
#include "private_domain.hpp"

#include <csignal>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// A service on a domain that nobody else uses. It ends with this object.
class PrivateBench {
 public:
  /// @param service the program vdrived
  /// @param arguments further ones, such as those of its clock
  /// @throws std::system_error, std::runtime_error
  PrivateBench(const std::string& service, const std::vector<std::string>& arguments);
  ~PrivateBench();
  PrivateBench(const PrivateBench&) = delete;
  PrivateBench& operator=(const PrivateBench&) = delete;

  [[nodiscard]] std::uint32_t domain() const noexcept { return domain_.number(); }

  /// Waits until the service runs. @return why it does not, or nothing.
  [[nodiscard]] std::optional<std::string> wait_until_ready();

  /// Ends it at once, and the wait above. Any thread.
  void end() const noexcept { service_.send(SIGTERM); }

 private:
  PrivateDomain domain_;
  Descriptor notifications_;
  ChildProcess service_;
};

/// @param chosen by the user; empty = vdrived beside this program, else the one in PATH
/// @throws UsageError when there is none.
[[nodiscard]] std::string find_service(const std::string& chosen);

/// @return the path of this program.
[[nodiscard]] std::string own_program();

}  // namespace vdrive::tool
