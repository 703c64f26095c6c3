// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"
#include "configuration/configuration.hpp"
#include "store/file_operations.hpp"
#include "store/parameter_file.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::service {

/// The content of a store when the service started.
struct LoadedParameters {
  enum class Source : std::uint8_t {
    nothing,   ///< nothing was ever stored, or nothing usable is left
    current,   ///< the current file
    previous,  ///< the previous file
  };

  ParameterTable table;
  Source source = Source::nothing;
  ParameterProblem problem = ParameterProblem::none;  ///< of the current file
  std::uint64_t number = 0;                           ///< see ParameterProblem
};

/// The stored parameters of one bench in a state directory. Its calls block, so the tick thread
/// must not use it.
///
/// | file                    | content                                                        |
/// | ----------------------- | -------------------------------------------------------------- |
/// | `bench-N.parameters`    | the stored parameters                                          |
/// | `....previous`          | the previously stored parameters                               |
/// | `....new`               | a file being written, or left by a power failure; ignored      |
/// | `....damaged`           | a file that could not be used, kept for inspection             |
/// | `bench-N.lock`          | empty; locked by the service that uses the other files         |
class ParameterStore {
 public:
  /// Creates the directory if only its last part is missing, removes the permissions of other
  /// users, and locks the bench. In a read-only directory nothing is locked, and `save` will fail.
  /// @throws ConfigurationError if the directory cannot be used, another service uses the same
  ///         bench, the directory or the lock file belongs to another user, or one of them is a
  ///         link that is not followed
  ParameterStore(std::filesystem::path directory, std::uint32_t bench,
                 std::unique_ptr<FileOperations> files = system_files());
  ~ParameterStore();
  ParameterStore(const ParameterStore&) = delete;
  ParameterStore& operator=(const ParameterStore&) = delete;

  [[nodiscard]] const std::filesystem::path& directory() const noexcept { return directory_; }

  /// Reads the stored parameters. Changes no files, except that a damaged file is also kept as
  /// `.damaged`.
  [[nodiscard]] LoadedParameters load();

  /// Replaces the stored parameters. When it returns, the new ones are durable. Whatever happens in
  /// between, either the previous or the new table is complete on disk. After an error the previous
  /// table is the stored one, unless the replacement could not be reverted, or power fails before
  /// the next save: the reversal itself is not synced.
  /// @throws std::system_error if a file cannot be written, synced or renamed
  void save(const ParameterTable& table);

  /// Also keeps the present file as `.damaged`. A failure is logged.
  void keep_damaged();

 private:
  /// The file that a save has replaced.
  struct Replaced {
    bool was_bad = false;
    std::filesystem::path name;  ///< its present name
    bool was_there = false;
  };

  [[nodiscard]] std::filesystem::path file(const char* suffix) const;
  [[nodiscard]] std::optional<std::string> lock();
  void require_private(int opened, const std::filesystem::path& path) const;
  [[noreturn]] void refuse(const std::string& problem) const;
  [[nodiscard]] ParameterTable read(const std::filesystem::path& file);
  void load_previous(LoadedParameters& loaded);
  void put_back();
  void write_new_file(std::span<const std::byte> content);
  Replaced replace();
  void take_back(const Replaced& replaced);
  [[nodiscard]] bool move_away(const std::filesystem::path& to);
  void sync_directory();

  std::filesystem::path directory_;
  std::string name_;
  std::unique_ptr<FileOperations> files_;
  int lock_ = -1;
  bool is_bad_ = false;   ///< the present file must not become the previous one
  bool is_kept_ = false;  ///< the bad file also has the name `.damaged`
  bool is_away_ = false;  ///< a save was interrupted: the present file is named `.previous`
};

/// @return the store of a bench in the directory given by `--state`, or else by $STATE_DIRECTORY of
///         systemd (the first of several); nullptr if neither is given.
/// @throws ConfigurationError as the constructor
[[nodiscard]] std::unique_ptr<ParameterStore> open_parameter_store(
    const std::optional<std::string>& directory, std::uint32_t bench);

/// Gives each axis of a bench its stored parameters. An axis with an unusable value keeps its
/// configured ones and has fault 5530h. If the current file could not be used, all axes have the
/// fault, even if the previous file was loaded.
/// @return the events to report
[[nodiscard]] std::vector<EventRecord> apply(const LoadedParameters& loaded,
                                             Configuration& configuration);

}  // namespace vdrive::service
