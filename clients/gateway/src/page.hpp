// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace vdrive::gateway {

/// A file of the web page, embedded by the build.
struct PageFile {
  std::string_view path;  ///< below the page's directory, such as "assets/index.js"
  std::string_view bytes;
};

using Page = std::span<const PageFile>;

/// @return the web page of this build; empty if the build had no node or no package registry.
[[nodiscard]] Page embedded_page();

/// The answer to an HTTP request.
struct PageAnswer {
  unsigned status = 200;
  std::string_view content_type;
  std::string_view cache_control;
  std::string_view bytes;
};

/// @param target of an HTTP request, such as "/?token=x"
/// @return the file for it; without a page, one that explains how to get it.
[[nodiscard]] PageAnswer find_page_file(Page page, std::string_view target);

/// Limits what the page may load and do: the value of the header Content-Security-Policy.
inline constexpr std::string_view kContentSecurityPolicy =
    "default-src 'self'; connect-src 'self'; img-src 'self' blob: data:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace vdrive::gateway
