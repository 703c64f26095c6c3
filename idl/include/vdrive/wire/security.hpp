// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// The files of a security directory, all of them required (deploy/security creates them).
struct SecurityFile {
  static constexpr std::string_view kIdentityCa = "identity_ca.pem";
  static constexpr std::string_view kCertificate = "certificate.pem";
  static constexpr std::string_view kPrivateKey = "private_key.pem";  ///< without pass phrase
  static constexpr std::string_view kPermissionsCa = "permissions_ca.pem";
  static constexpr std::string_view kGovernance = "governance.smime";
  static constexpr std::string_view kPermissions = "permissions.smime";
};

/// The topics that the signed permissions of an identity allow it to publish in one domain.
class Permissions {
 public:
  struct Rule {
    bool allows = false;
    std::vector<std::string> topics;  ///< patterns of fnmatch
  };

  Permissions() = default;

  /// @param rules in order; the first one that names a topic applies
  /// @param by_default whether a topic that no rule names may be published
  Permissions(std::vector<Rule> rules, bool by_default)
      : rules_(std::move(rules)), by_default_(by_default) {}

  /// @param topic its full name, such as vdrive/v1/command
  [[nodiscard]] bool may_publish(const std::string& topic) const;

 private:
  std::vector<Rule> rules_;
  bool by_default_ = false;
};

/// Checks the material of the closed mode: every file exists and is readable; certificate, key, CA
/// and signatures belong together and are valid now; the permissions belong to this identity; and
/// the governance document leaves none of our topics open in `domain`.
/// @return what the identity may publish
/// @throws NetworkError with the file and what is wrong with it
Permissions check_security(const std::filesystem::path& directory, std::uint32_t domain);

}  // namespace vdrive::wire
