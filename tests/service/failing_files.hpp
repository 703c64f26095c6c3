// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "store/file_operations.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

namespace vdrive::test {

/// Plans which file operations of a test fail.
struct FilePlan {
  /// Called before each operation with its number, from 1. If it throws, the operation fails with
  /// that exception.
  std::function<void(std::uint64_t number)> before;
  std::uint64_t count = 0;  ///< operations so far

  void set(std::function<void(std::uint64_t number)> what) {
    count = 0;
    before = std::move(what);
  }

  void step() {
    ++count;
    if (before) before(count);
  }
};

[[noreturn]] inline void fail_with(int code) {
  throw std::system_error(code, std::generic_category(), "injected");
}

/// The file operations of the system. They can be counted, made to fail, or interrupted by the end
/// of the process.
class FailingFiles final : public service::FileOperations {
 public:
  /// @param plan must outlive this object
  explicit FailingFiles(FilePlan& plan) : plan_(plan) {}

  void make_directory(const std::filesystem::path& directory) override {
    plan_.step();
    files_->make_directory(directory);
  }

  int open(const std::filesystem::path& file, Purpose purpose) override {
    plan_.step();
    return files_->open(file, purpose);
  }

  Privacy make_private(int file) override {
    plan_.step();
    return files_->make_private(file);
  }

  std::uint64_t size(int file) override {
    plan_.step();
    return files_->size(file);
  }

  std::size_t read(int file, std::span<std::byte> bytes) override {
    plan_.step();
    return files_->read(file, bytes);
  }

  /// Writes in two halves, so that a process can end in between.
  std::size_t write(int file, std::span<const std::byte> bytes) override {
    plan_.step();
    return files_->write(file, bytes.first((bytes.size() + 1) / 2));
  }

  void sync(int file) override {
    plan_.step();
    files_->sync(file);
  }

  bool try_lock(int file) override {
    plan_.step();
    return files_->try_lock(file);
  }

  std::string lock_holder(int file) override { return files_->lock_holder(file); }

  /// Closes even on failure, as the system does.
  void close(int file) override {
    files_->close(file);
    plan_.step();
  }

  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    plan_.step();
    files_->rename(from, to);
  }

  void link(const std::filesystem::path& from, const std::filesystem::path& to) override {
    plan_.step();
    files_->link(from, to);
  }

  void remove(const std::filesystem::path& file) override {
    plan_.step();
    files_->remove(file);
  }

  bool exists(const std::filesystem::path& file) override {
    plan_.step();
    return files_->exists(file);
  }

 private:
  FilePlan& plan_;
  std::unique_ptr<service::FileOperations> files_ = service::system_files();
};

}  // namespace vdrive::test
