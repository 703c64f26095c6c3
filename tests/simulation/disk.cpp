// SPDX-License-Identifier: Apache-2.0
#include "simulation/disk.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <system_error>
#include <utility>

namespace vdrive::simulation {
namespace {

[[noreturn]] void refuse(int code) {
  throw std::system_error(code, std::generic_category(), "simulated disk");
}

}  // namespace

class Disk::Files final : public service::FileOperations {
 public:
  explicit Files(Disk& disk) : disk_(disk) {}

  void make_directory(const std::filesystem::path& /*directory*/) override { disk_.step(); }

  int open(const std::filesystem::path& file, Purpose purpose) override {
    disk_.step();
    Open opened;
    if (purpose != Purpose::directory) {
      const bool is_there = disk_.names_.contains(file.string());
      if (purpose == Purpose::read && !is_there) refuse(ENOENT);
      if (purpose == Purpose::create && is_there) refuse(EEXIST);
      if (!is_there) {
        disk_.names_[file.string()] = std::make_shared<File>();
        disk_.change_names();
      }
      opened.file = disk_.names_[file.string()];
    }
    disk_.open_[++disk_.last_number_] = std::move(opened);
    return disk_.last_number_;
  }

  Privacy make_private(int /*file*/) override {
    disk_.step();
    return Privacy::kept;
  }

  std::uint64_t size(int file) override {
    disk_.step();
    return disk_.file_of(file).content.size();
  }

  std::size_t read(int file, std::span<std::byte> bytes) override {
    disk_.step();
    const std::string& content = disk_.file_of(file).content;
    std::size_t& position = disk_.open_[file].position;
    const std::size_t count = std::min(bytes.size(), content.size() - position);
    std::memcpy(bytes.data(), content.data() + position, count);
    position += count;
    return count;
  }

  /// Writes one half, then the other: a process can end in between.
  std::size_t write(int file, std::span<const std::byte> bytes) override {
    disk_.step();
    if (disk_.full_) {
      disk_.failed_ = true;
      refuse(ENOSPC);
    }
    const auto half = bytes.first(std::min(bytes.size(), bytes.size() / 2 + 64));
    disk_.file_of(file).content.append(reinterpret_cast<const char*>(half.data()), half.size());
    return half.size();
  }

  void sync(int file) override {
    disk_.step();
    if (disk_.lies_) return;
    if (disk_.open_.at(file).file == nullptr) {
      disk_.since_sync_ = {disk_.names_};
    } else {
      disk_.file_of(file).synced = disk_.file_of(file).content.size();
    }
  }

  bool try_lock(int /*file*/) override {
    disk_.step();
    return !std::exchange(disk_.locked_, true);
  }

  std::string lock_holder(int /*file*/) override { return "another simulated service"; }

  /// Closes even on failure, as the operating system does.
  void close(int file) override {
    disk_.open_.erase(file);
    disk_.step();
  }

  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    disk_.step();
    const auto named = disk_.names_.find(from.string());
    if (named == disk_.names_.end()) refuse(ENOENT);
    const bool is_new = from.extension() == ".new";
    auto file = std::move(named->second);
    disk_.names_.erase(named);
    disk_.names_[to.string()] = std::move(file);
    disk_.replaced_ = disk_.replaced_ || is_new;
    disk_.change_names();
  }

  void link(const std::filesystem::path& from, const std::filesystem::path& to) override {
    disk_.step();
    if (!disk_.names_.contains(from.string())) refuse(ENOENT);
    disk_.names_[to.string()] = disk_.names_[from.string()];
    disk_.change_names();
  }

  void remove(const std::filesystem::path& file) override {
    disk_.step();
    if (disk_.names_.erase(file.string()) == 0) refuse(ENOENT);
    disk_.change_names();
  }

  bool exists(const std::filesystem::path& file) override {
    disk_.step();
    return file == kDirectory || disk_.names_.contains(file.string());
  }

 private:
  Disk& disk_;
};

std::unique_ptr<service::FileOperations> Disk::files() {
  return std::make_unique<Files>(*this);
}

void Disk::fail_in(std::uint64_t number, int code) {
  fail_in_ = number;
  code_ = code;
}

void Disk::kill_in(std::uint64_t number) {
  kill_in_ = number;
}

void Disk::begin_save() {
  count_ = 0;
  is_saving_ = true;
  failed_ = replaced_ = false;
}

/// Every operation begins here.
void Disk::step() {
  ++count_;
  killed_ = killed_ || (is_saving_ && kill_in_ != 0 && count_ == kill_in_);
  if (killed_) {
    failed_ = true;
    refuse(EIO);
  }
  if (is_saving_ && fail_in_ != 0 && count_ == fail_in_) {
    fail_in_ = 0;
    failed_ = true;
    refuse(code_);
  }
}

void Disk::change_names() {
  since_sync_.push_back(names_);
}

Disk::File& Disk::file_of(int number) {
  const auto opened = open_.find(number);
  if (opened == open_.end() || opened->second.file == nullptr) refuse(EBADF);
  return *opened->second.file;
}

void Disk::end_process(bool power_fails) {
  open_.clear();
  locked_ = is_saving_ = killed_ = false;
  fail_in_ = kill_in_ = 0;
  if (!power_fails && !lies_) return;
  names_ = since_sync_[random_.below(since_sync_.size())];
  since_sync_ = {names_};
  for (auto& [name, file] : names_) {
    file->content.resize(file->synced + random_.below(file->content.size() - file->synced + 1));
    file->synced = file->content.size();
  }
}

}  // namespace vdrive::simulation
