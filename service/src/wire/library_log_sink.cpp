// SPDX-License-Identifier: Apache-2.0
#include "wire/library_log_sink.hpp"

#include "base/log.hpp"
#include "vdrive/text.hpp"
#include "vdrive/token_bucket.hpp"

#include <algorithm>
#include <chrono>
#include <string>

namespace vdrive::service {

wire::LibraryLog::Sink log_of_the_library(std::uint32_t bench) {
  return [bench, limit = CountingLimit(kRepeatedLines)](const std::string& part,
                                                        const std::string& words) mutable {
    if (const auto suppressed = limit.pass(std::chrono::steady_clock::now().time_since_epoch())) {
      std::string text = escaped(words, kShownOfMessage);
      std::ranges::replace(text, '"', '\'');
      log_warning("dds={} bench={} suppressed={} text=\"{}\"", part, bench, *suppressed, text);
    }
  };
}

}  // namespace vdrive::service
