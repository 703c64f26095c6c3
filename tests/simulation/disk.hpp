// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "store/file_operations.hpp"
#include "support/random_cases.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::simulation {

using test::Random;

/// A disk with the state directory of the service; it outlasts the service's runs. A power failure
/// loses part of what was not synced: of a file everything but its first bytes, of the names the
/// latest changes. Changes of names are lost only together with all later ones: file systems keep
/// the order of their journal.
class Disk {
 public:
  static constexpr const char* kDirectory = "/state";

  explicit Disk(std::uint64_t seed) : random_(seed) {}

  /// @return the file operations of one process; the disk must outlive it.
  [[nodiscard]] std::unique_ptr<service::FileOperations> files();

  /// The next save fails once, with this errno, in its operation `number`, from 1.
  void fail_in(std::uint64_t number, int code);

  /// The process ends before operation `number` of the next save.
  void kill_in(std::uint64_t number);

  /// While full, no byte can be written.
  void fill(bool full) { full_ = full; }

  /// Counts operations from here, for one save.
  void begin_save();

  /// Whether an operation of this save failed.
  [[nodiscard]] bool has_failed() const { return failed_; }

  /// Whether that operation came after the rename of the new file. If so, only the durability of
  /// the file is unknown.
  [[nodiscard]] bool has_replaced() const { return replaced_; }

  /// The process ended in this save: its further operations have no effect.
  [[nodiscard]] bool is_killed() const { return killed_; }

  /// The process has ended. @param power_fails whether part of what was not synced is lost
  void end_process(bool power_fails);

  /// From now on the disk reports success, but no sync has an effect.
  void lie() { lies_ = true; }

 private:
  class Files;

  struct File {
    std::string content;
    std::size_t synced = 0;  ///< number of bytes that are durable
  };

  using Names = std::map<std::string, std::shared_ptr<File>>;

  struct Open {
    std::shared_ptr<File> file;  ///< nullptr: the directory
    std::size_t position = 0;
  };

  void step();
  void change_names();
  File& file_of(int number);

  Random random_;
  Names names_;
  std::vector<Names> since_sync_{Names{}};  ///< durable names, and after each later change
  std::map<int, Open> open_;
  int last_number_ = 2;
  bool locked_ = false;
  bool full_ = false;
  bool lies_ = false;
  std::uint64_t count_ = 0;
  std::uint64_t fail_in_ = 0;  ///< 0 = never
  std::uint64_t kill_in_ = 0;
  int code_ = 0;
  bool is_saving_ = false;
  bool failed_ = false;
  bool replaced_ = false;
  bool killed_ = false;
};

}  // namespace vdrive::simulation
