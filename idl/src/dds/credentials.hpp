// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace vdrive::wire {

/// Checks that certificate and key match, that the CA issued the certificate, and that the
/// certificates are valid now.
/// @return the subject of the certificate in the form used by permissions (RFC 2253)
/// @throws NetworkError
[[nodiscard]] std::string check_identity(const std::filesystem::path& ca_file,
                                         const std::filesystem::path& certificate_file,
                                         const std::filesystem::path& key_file);

/// Checks that `ca` itself signed `document` (S/MIME) and is valid now. @return the text of the
/// document.
/// @throws NetworkError
[[nodiscard]] std::string verified_text(const std::filesystem::path& ca,
                                        const std::filesystem::path& document);

}  // namespace vdrive::wire
