// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording.hpp"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace vdrive::recording {

/// Passes data to a writer on a separate thread, so that the receiving thread never waits. When the
/// queue is full, samples are dropped and counted until the writer has made room.
class RecordingQueue {
 public:
  /// Most waiting status images; 64 MB, half a second of 1,024 axes at 1 kHz.
  static constexpr std::size_t kMostImages = std::size_t{512} * 1024;
  /// Most waiting events.
  static constexpr std::size_t kMostEvents = 4096;

  /// @param writer begin() must have been called on it
  /// @param most_images the most status images that may wait; an empty queue accepts any sample
  explicit RecordingQueue(std::unique_ptr<Writer> writer, std::size_t most_images = kMostImages);

  /// Ends the thread; without finish() the recording has no end.
  ~RecordingQueue();
  RecordingQueue(const RecordingQueue&) = delete;
  RecordingQueue& operator=(const RecordingQueue&) = delete;

  /// May be called by any thread.
  void push(client::Observation sample);
  void push(const client::Event& event);

  /// @return why recording has stopped; empty while it continues.
  [[nodiscard]] std::string failure() const;

  /// Writes the waiting data and the end of the recording. Call once, last.
  /// @return the final figures
  /// @throws RecordingError if something could not be written
  Summary finish();

 private:
  using Item = std::variant<client::Observation, client::Event>;

  /// Samples not recorded because the queue was full.
  struct Dropped {
    std::uint64_t samples = 0;
    std::uint64_t skipped = 0;  ///< ticks that were never run, so nothing was lost
  };

  void run();
  void write(const std::deque<Item>& items);

  std::unique_ptr<Writer> writer_;
  const std::size_t most_images_;

  mutable std::mutex mutex_;  ///< guards all members below except the thread
  std::condition_variable ending_;
  std::deque<Item> items_;
  std::size_t images_ = 0;  ///< in `items_` and in the items taken by the thread
  std::size_t events_ = 0;
  std::map<std::uint32_t, Dropped> dropped_;  ///< since the last accepted sample, by bench
  Summary summary_;
  std::string failure_;
  bool is_ending_ = false;
  std::thread thread_;
};

}  // namespace vdrive::recording
