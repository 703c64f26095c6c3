// SPDX-License-Identifier: Apache-2.0
#include "recording_queue.hpp"

#include <chrono>
#include <utility>

namespace vdrive::recording {
namespace {

// Samples do not wake the thread: a thousand wake-ups per second would cost more than the writing.
constexpr std::chrono::milliseconds kPeriod{10};

}  // namespace

RecordingQueue::RecordingQueue(std::unique_ptr<Writer> writer, std::size_t most_images)
    : writer_(std::move(writer)), most_images_(most_images) {
  thread_ = std::thread([this] {
    run();
  });
}

RecordingQueue::~RecordingQueue() {
  {
    const std::scoped_lock lock(mutex_);
    is_ending_ = true;
  }
  ending_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void RecordingQueue::push(client::Observation sample) {
  if (sample.axes.empty()) return;
  const std::uint32_t bench = sample.axes.front().id.bench;
  const std::scoped_lock lock(mutex_);
  if (!failure_.empty()) return;
  Dropped& dropped = dropped_[bench];
  if (images_ != 0 && images_ + sample.axes.size() > most_images_) {
    dropped.samples += 1 + sample.missed;
    dropped.skipped += sample.skipped;
    return;
  }
  sample.missed += std::exchange(dropped.samples, 0);
  sample.skipped += std::exchange(dropped.skipped, 0);
  summary_.gaps.note_sample(sample);
  ++summary_.samples;
  images_ += sample.axes.size();
  items_.emplace_back(std::move(sample));
}

void RecordingQueue::push(const client::Event& event) {
  const std::scoped_lock lock(mutex_);
  if (!failure_.empty()) return;
  if (events_ >= kMostEvents) {
    ++summary_.events_lost;
    return;
  }
  ++events_;
  ++summary_.events;
  items_.emplace_back(event);
}

std::string RecordingQueue::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

void RecordingQueue::run() {
  bool goes_on = true;
  while (goes_on) {
    std::deque<Item> items;
    {
      std::unique_lock lock(mutex_);
      ending_.wait_for(lock, kPeriod, [this] {
        return is_ending_;
      });
      items.swap(items_);
      events_ = 0;
      goes_on = !is_ending_ || !items.empty();
    }
    try {
      write(items);
    } catch (const RecordingError& error) {
      const std::scoped_lock lock(mutex_);
      failure_ = error.what();
      items_.clear();
      return;
    }
  }
}

void RecordingQueue::write(const std::deque<Item>& items) {
  for (const Item& item : items) {
    if (const auto* event = std::get_if<client::Event>(&item)) {
      writer_->event(*event);
      continue;
    }
    const auto& sample = std::get<client::Observation>(item);
    writer_->status(sample);
    const std::scoped_lock lock(mutex_);
    images_ -= sample.axes.size();
  }
  writer_->flush(Writer::Clock::now());
}

Summary RecordingQueue::finish() {
  {
    const std::scoped_lock lock(mutex_);
    is_ending_ = true;
  }
  ending_.notify_one();
  thread_.join();
  const std::scoped_lock lock(mutex_);
  for (const auto& [bench, dropped] : dropped_) summary_.gaps.note_lost_end(bench, dropped.samples);
  if (!failure_.empty()) throw RecordingError(failure_);
  writer_->finish(summary_);
  return summary_;
}

}  // namespace vdrive::recording
