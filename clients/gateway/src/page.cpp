// SPDX-License-Identifier: Apache-2.0
#include "page.hpp"

#include <algorithm>
#include <array>

namespace vdrive::gateway {
namespace {

constexpr std::string_view kIndex = "index.html";
constexpr std::string_view kText = "text/plain; charset=utf-8";

constexpr std::string_view kFallback = R"(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>vdrive-gateway</title>
<h1>vdrive-gateway</h1>
<p>The gateway runs: Foxglove, Lichtblick and PlotJuggler can connect to this address by WebSocket.
<p>This build does not include the web page. Building the page needs node, npm and the npm registry:
<pre>deploy/setup.sh --page
deploy/build.sh --target vdrive-gateway</pre>
</html>
)";

struct TypeRow {
  std::string_view ending;
  std::string_view type;
};

constexpr std::array kTypes{
    TypeRow{".html", "text/html; charset=utf-8"},
    TypeRow{".js", "text/javascript; charset=utf-8"},
    TypeRow{".css", "text/css; charset=utf-8"},
    TypeRow{".svg", "image/svg+xml"},
    TypeRow{".json", "application/json"},
    TypeRow{".png", "image/png"},
    TypeRow{".ico", "image/x-icon"},
    TypeRow{".woff2", "font/woff2"},
    TypeRow{".webmanifest", "application/manifest+json"},
};

std::string_view type_of(std::string_view path) {
  const auto* const row = std::ranges::find_if(kTypes, [&](const TypeRow& candidate) {
    return path.ends_with(candidate.ending);
  });
  return row == kTypes.end() ? "application/octet-stream" : row->type;
}

}  // namespace

PageAnswer find_page_file(Page page, std::string_view target) {
  std::string_view path = target.substr(0, target.find_first_of("?#"));
  if (path.starts_with('/')) path.remove_prefix(1);
  if (path.empty()) path = kIndex;
  for (const PageFile& file : page) {
    if (file.path != path) continue;
    // Asset names contain a hash of the content, so a changed file has a new name.
    const bool is_lasting = path.starts_with("assets/");
    return {.status = 200,
            .content_type = type_of(path),
            .cache_control = is_lasting ? "public, max-age=31536000, immutable" : "no-cache",
            .bytes = file.bytes};
  }
  if (page.empty() && path == kIndex) {
    return {.status = 200,
            .content_type = type_of(kIndex),
            .cache_control = "no-store",
            .bytes = kFallback};
  }
  return {.status = 404,
          .content_type = kText,
          .cache_control = "no-store",
          .bytes = "The gateway has no such file.\n"};
}

}  // namespace vdrive::gateway
