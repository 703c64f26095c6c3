// SPDX-License-Identifier: Apache-2.0
#include "base/report_thread.hpp"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <thread>
#include <utility>

namespace vdrive::client {
namespace {

/// Reporters are identified by a number, not by their address: a report may destroy its
/// ReportThread while the thread still runs, and the address may then be reused.
std::uint64_t next_reporter() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

/// The number of the ReportThread that this thread reports for, 0 = none.
std::uint64_t& reporter_of_this_thread() noexcept {
  thread_local std::uint64_t reporter = 0;
  return reporter;
}

}  // namespace

struct ReportThreads::Run {
  explicit Run(std::uint64_t its_reporter) : reporter(its_reporter) {}

  const std::uint64_t reporter;
  std::atomic<bool> is_over = false;
  std::once_flag joined;  ///< several threads may wait for it
  std::jthread thread;
};

ReportThreads::ReportThreads() = default;

ReportThreads::~ReportThreads() {
  end();
}

void ReportThreads::end() {
  {
    const std::scoped_lock lock(mutex_);
    is_ended_ = true;
  }
  end_runs(std::nullopt);
}

void ReportThreads::end_runs(std::optional<std::uint64_t> reporter) {
  std::vector<std::shared_ptr<Run>> ended;
  {
    const std::scoped_lock lock(mutex_);
    std::ranges::copy_if(runs_, std::back_inserter(ended), [reporter](const auto& run) {
      return !reporter || run->reporter == *reporter;
    });
  }
  for (const auto& run : ended) run->thread.request_stop();
  // A report waits neither for itself nor for a report that replaced it or was replaced by it,
  // because that report may be waiting for this one. A later call joins them, at the latest
  // ReportThreads::end() at the end of the session.
  std::erase_if(ended, [](const auto& run) {
    return run->reporter == reporter_of_this_thread() && !run->is_over;
  });
  for (const auto& run : ended) {
    std::call_once(run->joined, [&run] {
      run->thread.join();
    });
  }
  const std::scoped_lock lock(mutex_);
  std::erase_if(runs_, [&ended](const auto& run) {
    return std::ranges::find(ended, run) != ended.end();
  });
}

ReportThread::ReportThread(ReportThreads& threads) : threads_(threads), number_(next_reporter()) {}

void ReportThread::stop() {
  threads_.end_runs(number_);
}

void ReportThread::start(Work work) {
  while (true) {
    stop();
    const std::scoped_lock lock(threads_.mutex_);
    if (threads_.is_ended_) return;
    const bool has_another = std::ranges::any_of(threads_.runs_, [this](const auto& run) {
      return run->reporter == number_ && !run->thread.get_stop_source().stop_requested();
    });
    if (has_another) continue;  // another call has started one in the meantime
    const auto run = std::make_shared<ReportThreads::Run>(number_);
    // The run must outlive its thread: the list keeps it until the thread has been joined.
    run->thread = std::jthread(
        [its = run.get(), work = std::move(work)](const std::stop_token& stop_token) mutable {
          reporter_of_this_thread() = its->reporter;
          work(stop_token);
          work = nullptr;  // destroying its captures may end reports too
          its->is_over = true;
        });
    threads_.runs_.push_back(run);
    return;
  }
}

}  // namespace vdrive::client
