// SPDX-License-Identifier: Apache-2.0
#include "publish/session_names.hpp"

#include <algorithm>
#include <cstddef>

namespace vdrive::service {
namespace {

bool is_same(const msg::BenchSession& known, const msg::SessionName& name) {
  return known.program == name.program && known.process == name.process && known.host == name.host;
}

}  // namespace

bool SessionNames::note(const msg::SessionName& name) {
  if (name.session == 0 || name.bench != bench_) return false;
  auto known = std::ranges::find_if(sessions_, [&name](const msg::BenchSession& session) {
    return session.session == name.session;
  });
  if (known != sessions_.end() && is_same(*known, name)) return false;
  if (known == sessions_.end() && sessions_.size() < kMost) {
    known = sessions_.emplace(sessions_.end());
  } else if (known == sessions_.end()) {
    known = sessions_.begin() + static_cast<std::ptrdiff_t>(oldest_);
    oldest_ = (oldest_ + 1) % kMost;
  }
  const auto place = static_cast<std::uint16_t>(known - sessions_.begin());
  known->bench = bench_;
  known->place = place;
  known->session = name.session;
  known->program = name.program;
  known->process = name.process;
  known->host = name.host;
  if (std::ranges::find(unpublished_, place) == unpublished_.end()) unpublished_.push_back(place);
  return true;
}

const msg::BenchSession* SessionNames::next() const noexcept {
  return unpublished_.empty() ? nullptr : &sessions_[unpublished_.front()];
}

void SessionNames::pop() noexcept {
  if (!unpublished_.empty()) unpublished_.erase(unpublished_.begin());
}

void SessionNames::begin_again() {
  unpublished_.clear();
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    unpublished_.push_back(static_cast<std::uint16_t>((oldest_ + i) % sessions_.size()));
  }
}

}  // namespace vdrive::service
