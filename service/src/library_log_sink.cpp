// SPDX-License-Identifier: Apache-2.0
#include "library_log_sink.hpp"

#include "repeat_limiter.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <string>

namespace vdrive::service {

wire::LibraryLog::Sink log_of_the_library(std::uint32_t bench) {
  return [bench, limiter = RepeatLimiter()](const std::string& part,
                                            const std::string& words) mutable {
    constexpr std::size_t kLongest = 256;
    if (const auto suppressed = limiter.pass(std::chrono::steady_clock::now())) {
      std::string text = words.substr(0, kLongest);
      std::replace_if(
          text.begin(), text.end(),
          [](char letter) {
            return letter == '"' || std::iscntrl(static_cast<unsigned char>(letter)) != 0;
          },
          ' ');
      spdlog::warn("dds={} bench={} suppressed={} text=\"{}\"", part, bench, *suppressed, text);
    }
  };
}

}  // namespace vdrive::service
