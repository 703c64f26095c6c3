// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace vdrive::test {

/// An authority and its members, made by the scripts of deploy/security in a temporary directory
/// that is removed in the destructor.
class Authority {
 public:
  Authority();
  ~Authority();
  Authority(const Authority&) = delete;
  Authority& operator=(const Authority&) = delete;

  /// @param words the arguments of make_member.sh after the directory: "viewer NAME --days 1"
  /// @return the member's directory
  std::filesystem::path member(const std::string& words) const;

  /// Signs a document as the permissions CA would.
  void sign(const std::filesystem::path& xml, const std::filesystem::path& document) const;

  [[nodiscard]] const std::filesystem::path& directory() const noexcept { return directory_; }

 private:
  std::filesystem::path root_;
  std::filesystem::path directory_;
};

struct ShellResult {
  int code = 0;
  std::string text;  ///< standard output and standard error
};

ShellResult shell(const std::string& command);

[[nodiscard]] std::string read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, const std::string& text);

}  // namespace vdrive::test
