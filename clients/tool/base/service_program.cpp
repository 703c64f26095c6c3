// SPDX-License-Identifier: Apache-2.0
#include "base/service_program.hpp"

#include "base/usage_error.hpp"
#include "private_bench.hpp"
#include "vdrive/text.hpp"

#include <filesystem>

namespace vdrive::tool {

std::string find_service(const std::string& chosen) {
  if (!chosen.empty()) {
    if (!process::is_program(chosen)) {
      throw UsageError("--service: " + in_quotes(chosen) + " is not a program");
    }
    return std::filesystem::absolute(chosen).string();
  }
  if (auto found = process::find_service()) return *found;
  throw UsageError("there is no vdrived next to this program or in PATH: give --service FILE");
}

}  // namespace vdrive::tool
