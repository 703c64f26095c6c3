// SPDX-License-Identifier: Apache-2.0
#include "store/parameter_store.hpp"

#include "base/event_codes.hpp"
#include "base/log.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/text.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <optional>
#include <system_error>
#include <utility>

namespace vdrive::service {
namespace {

using Purpose = FileOperations::Purpose;

constexpr std::size_t kReadSize = 65'536;

bool is_error(const std::system_error& error, int code) {
  return error.code() == std::error_code(code, std::generic_category());
}

/// Closes its file when it is destroyed.
class OpenFile {
 public:
  OpenFile(FileOperations& files, const std::filesystem::path& file, Purpose purpose)
      : files_(files), number_(files.open(file, purpose)) {}

  ~OpenFile() {
    try {
      close();
    } catch (const std::system_error& error) {
      log_debug("{}", error.what());  // harmless: it was only read, or a write has already failed
    }
  }

  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] int number() const noexcept { return number_; }

  void close() {
    if (number_ >= 0) files_.close(std::exchange(number_, -1));
  }

  int release() noexcept { return std::exchange(number_, -1); }

 private:
  FileOperations& files_;
  int number_;
};

/// Calls `function`, and only logs a failure. @return whether it succeeded
template <typename Function>
bool attempt(const char* what, Function function) {
  try {
    function();
    return true;
  } catch (const std::system_error& error) {
    log_warning("{}: {}", what, error.what());
    return false;
  }
}

/// @return the first unusable value of the axis, and why; nullopt if there is none.
std::optional<StoredProblem> refusal_of(const std::vector<InitialValue>& values) {
  for (const InitialValue& stored : values) {
    const AbortCode code = AxisBank::check_stored(stored.address, stored.value);
    if (code == AbortCode::none) continue;
    const auto row = find_object(stored.address);
    const bool is_stored = row && describe(*row).storage == Storage::flash;
    return StoredProblem{
        is_stored ? ParameterProblem::refused_value : ParameterProblem::unknown_object,
        stored.address.index * 256U + stored.address.subindex};
  }
  return std::nullopt;
}

}  // namespace

ParameterStore::ParameterStore(std::filesystem::path directory, std::uint32_t bench,
                               std::unique_ptr<FileOperations> files)
    : directory_(std::move(directory)),
      name_("bench-" + std::to_string(bench)),
      files_(std::move(files)) {
  try {
    if (!files_->exists(directory_)) files_->make_directory(directory_);
    OpenFile opened(*files_, directory_, Purpose::directory);
    require_private(opened.number(), directory_);
    opened.close();
  } catch (const std::system_error& error) {
    refuse(is_error(error, ELOOP) ? "is a symbolic link of another user, which is not followed"
                                  : "cannot be used: " + error.code().message());
  }
  if (const auto holder = lock()) {
    refuse("the parameters of bench " + std::to_string(bench) + " are in use by " + *holder +
           "; stop it, or use a different state directory");
  }
}

void ParameterStore::refuse(const std::string& problem) const {
  throw ConfigurationError("state directory " + escaped(directory_.string(), kShownOfMessage) +
                           ": " + problem);
}

/// Required because anyone who can open the lock file can hold its lock, and anyone who can write
/// to the directory can replace the file.
void ParameterStore::require_private(int opened, const std::filesystem::path& path) const {
  switch (files_->make_private(opened)) {
    case FileOperations::Privacy::kept:
      return;
    case FileOperations::Privacy::narrowed:
      log_info("{}: removed the permissions of other users", path.string());
      return;
    case FileOperations::Privacy::foreign:
      refuse(escaped(path.filename().string()) +
             " belongs to another user, or everybody may write to it; use a directory of the user "
             "that runs vdrived");
  }
}

ParameterStore::~ParameterStore() {
  if (lock_ >= 0) {
    attempt("lock file", [this] {
      files_->close(lock_);
    });
  }
}

std::filesystem::path ParameterStore::file(const char* suffix) const {
  return directory_ / (name_ + ".parameters" + suffix);
}

/// If the lock file cannot be created, the other files cannot be written either; a later save tries
/// again.
/// @return the holder of the lock if it is another service
std::optional<std::string> ParameterStore::lock() {
  try {
    const auto path = directory_ / (name_ + ".lock");
    OpenFile opened(*files_, path, Purpose::lock);
    require_private(opened.number(), path);
    if (!files_->try_lock(opened.number())) return files_->lock_holder(opened.number());
    lock_ = opened.release();
  } catch (const std::system_error& error) {
    if (is_error(error, ELOOP)) refuse(name_ + ".lock is a symbolic link, which is not followed");
    log_warning("state directory {}: cannot be locked, so parameters cannot be stored: {}",
                directory_.string(), error.what());
  }
  return std::nullopt;
}

// ---- load ------------------------------------------------------------------------------------

ParameterTable ParameterStore::read(const std::filesystem::path& file) {
  try {
    const OpenFile opened(*files_, file, Purpose::read);
    const std::uint64_t size = files_->size(opened.number());
    if (size > kLargestParameterFile) {
      throw ParameterFileError(ParameterProblem::too_large, size, "it is too large");
    }
    std::vector<std::byte> content;
    std::vector<std::byte> part(kReadSize);
    while (const std::size_t count = files_->read(opened.number(), part)) {
      content.insert(content.end(), part.begin(),
                     part.begin() + static_cast<std::ptrdiff_t>(count));
      if (content.size() > kLargestParameterFile) {
        throw ParameterFileError(
            ParameterProblem::too_large, content.size(),
            "it grew beyond " + std::to_string(kLargestParameterFile) + " bytes while it was read");
      }
    }
    return decode(content);
  } catch (const std::system_error& error) {
    if (is_error(error, ENOENT)) {
      throw ParameterFileError(ParameterProblem::missing, 0, "it is missing");
    }
    throw ParameterFileError(ParameterProblem::unreadable,
                             static_cast<std::uint64_t>(error.code().value()), error.what());
  }
}

LoadedParameters ParameterStore::load() {
  LoadedParameters loaded;
  try {
    loaded.table = read(file(""));
    loaded.source = LoadedParameters::Source::current;
    return loaded;
  } catch (const ParameterFileError& error) {
    loaded.problem = error.problem();
    loaded.number = error.number();
    if (loaded.problem != ParameterProblem::missing) {
      log_error("{}: {}: {}", file("").string(), describe_problem(loaded.problem, loaded.number),
                error.what());
      is_bad_ = true;
      keep_damaged();
    }
  }
  load_previous(loaded);
  return loaded;
}

/// Loads the previous file, because the current one is missing or cannot be used.
void ParameterStore::load_previous(LoadedParameters& loaded) {
  try {
    loaded.table = read(file(".previous"));
    loaded.source = LoadedParameters::Source::previous;
    // A save was interrupted between its two renames: the previous file is what was stored last.
    if (loaded.problem == ParameterProblem::missing && files_->exists(file(".new"))) {
      loaded.problem = ParameterProblem::none;
      is_away_ = true;
    }
  } catch (const ParameterFileError& error) {
    const bool is_missing = error.problem() == ParameterProblem::missing;
    if (!is_missing) {
      log_error("{}: {}: {}", file(".previous").string(),
                describe_problem(error.problem(), error.number()), error.what());
    }
    if (loaded.problem == ParameterProblem::missing) {  // if both are missing, nothing was stored
      loaded.problem = is_missing ? ParameterProblem::none : error.problem();
      loaded.number = error.number();
    }
  } catch (const std::system_error& error) {
    log_warning("{}", error.what());
  }
}

void ParameterStore::keep_damaged() {
  is_kept_ = attempt("the damaged file could not be kept", [this] {
    const auto damaged = file(".damaged");
    if (files_->exists(damaged)) files_->remove(damaged);
    files_->link(file(""), damaged);
  });
}

// ---- save ------------------------------------------------------------------------------------

void ParameterStore::save(const ParameterTable& table) {
  if (lock_ < 0 && (lock() || lock_ < 0)) {
    throw std::system_error(EROFS, std::generic_category(),
                            "state directory " + directory_.string() + " is not locked");
  }
  put_back();
  const std::string content = encode(table);
  write_new_file(std::as_bytes(std::span(content)));
  const Replaced replaced = replace();
  try {
    sync_directory();
  } catch (const std::system_error&) {
    attempt(
        "a failed save could not be reverted; the refused parameters may be used after a restart",
        [this, &replaced] {
          take_back(replaced);
        });
    throw;
  }
}

/// Undoes the first half of an interrupted replacement.
void ParameterStore::put_back() {
  if (is_away_) {
    files_->rename(file(".previous"), file(""));
    is_away_ = false;
  }
}

void ParameterStore::write_new_file(std::span<const std::byte> content) {
  const auto path = file(".new");
  if (files_->exists(path)) files_->remove(path);
  OpenFile opened(*files_, path, Purpose::create);
  try {
    while (!content.empty()) content = content.subspan(files_->write(opened.number(), content));
    files_->sync(opened.number());
    opened.close();
  } catch (const std::system_error&) {
    attempt("an unfinished file could not be removed", [this, &path] {
      files_->remove(path);  // a full disk needs its space
    });
    throw;
  }
}

/// The first rename moves the present file away, the second one puts the new file in its place: at
/// any time there is a complete file under one of the two names, even on file systems without
/// links. A bad file that also has the name `.damaged` is not moved away, so that a restart before
/// the second rename still finds it bad.
ParameterStore::Replaced ParameterStore::replace() {
  Replaced before{.was_bad = is_bad_, .name = file(is_bad_ ? ".damaged" : ".previous")};
  before.was_there = (is_bad_ && is_kept_) || move_away(before.name);
  is_away_ = before.was_there && !is_bad_;
  try {
    files_->rename(file(".new"), file(""));
  } catch (const std::system_error&) {
    attempt("the stored file could not be renamed back", [this] {
      put_back();
    });
    throw;
  }
  is_away_ = false;
  is_bad_ = false;
  return before;
}

/// Reverts a replacement, because its request is refused: the new set must not be used after a
/// restart.
void ParameterStore::take_back(const Replaced& replaced) {
  files_->rename(file(""), file(".new"));
  if (replaced.was_there) {
    is_away_ = !replaced.was_bad;
    files_->rename(replaced.name, file(""));
    is_away_ = false;
    is_bad_ = replaced.was_bad;
    is_kept_ = false;
  }
}

/// @return whether there was a file to move.
bool ParameterStore::move_away(const std::filesystem::path& to) {
  try {
    files_->rename(file(""), to);
    return true;
  } catch (const std::system_error& error) {
    if (is_error(error, ENOENT)) return false;
    throw;
  }
}

void ParameterStore::sync_directory() {
  OpenFile directory(*files_, directory_, Purpose::directory);
  files_->sync(directory.number());
  directory.close();
}

// ---- the way to the axes ---------------------------------------------------------------------

std::unique_ptr<ParameterStore> open_parameter_store(const std::optional<std::string>& directory,
                                                     std::uint32_t bench) {
  std::string path = directory.value_or("");
  if (!directory) {
    const char* const variable = std::getenv("STATE_DIRECTORY");  // NOLINT(concurrency-mt-unsafe)
    path = variable == nullptr ? "" : variable;
    path.resize(std::min(path.size(), path.find(':')));
    if (path.empty()) return nullptr;
  }
  if (path.empty()) throw ConfigurationError("--state: the name of the directory is empty");
  return std::make_unique<ParameterStore>(path, bench);
}

std::vector<EventRecord> apply(const LoadedParameters& loaded, Configuration& configuration) {
  std::vector<EventRecord> news;
  const bool is_good = loaded.problem == ParameterProblem::none;
  const auto report = [&news](std::uint32_t code, const EventDetail& detail,
                              std::uint16_t axis = 0) {
    news.push_back(
        {.kind = msg::EventKind::parameters, .axis = axis, .code = code, .detail = detail});
  };
  if (!is_good) {
    const bool has_previous = loaded.source == LoadedParameters::Source::previous;
    report(has_previous ? ParameterCode::kPrevious : ParameterCode::kDefaults,
           StoredProblem{loaded.problem, loaded.number});
  }
  std::uint64_t axes = 0;
  for (NamedAxis& axis : configuration.axes) {
    axis.configuration.memory_error = !is_good;
    const auto found = loaded.table.find(axis.number);
    if (found == loaded.table.end()) continue;
    if (const auto refusal = refusal_of(found->second)) {
      axis.configuration.memory_error = true;
      report(ParameterCode::kDefaults, *refusal, axis.number);
    } else {
      axis.configuration.stored = found->second;
      ++axes;
    }
  }
  if (loaded.source != LoadedParameters::Source::nothing)
    report(ParameterCode::kLoaded, Count{axes});
  return news;
}

}  // namespace vdrive::service
