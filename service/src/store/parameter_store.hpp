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

/// What a store held when the service started.
struct LoadedParameters {
  enum class Source : std::uint8_t {
    nothing,   ///< nothing was ever stored, or nothing of it is left
    current,   ///< the file
    previous,  ///< the file before it
  };

  ParameterTable table;
  Source source = Source::nothing;
  ParameterProblem problem = ParameterProblem::none;  ///< of the file
  std::uint64_t number = 0;                           ///< see ParameterProblem
};

/// The stored parameters of one bench in a state directory. Blocks: not for the thread that ticks.
///
/// | file                    | holds                                                          |
/// | ----------------------- | -------------------------------------------------------------- |
/// | `bench-N.parameters`    | what is stored                                                 |
/// | `....previous`          | what was stored before                                         |
/// | `....new`               | what is being written, or was when the power failed: ignored   |
/// | `....damaged`           | a file that could not be used, kept aside                      |
/// | `bench-N.lock`          | nothing; locked by the service that uses the others            |
class ParameterStore {
 public:
  /// Makes the directory if only its last part is missing, takes the rights of other users to it,
  /// and locks the bench.
  /// @throws ConfigurationError when it cannot be used, or another service uses the same bench,
  ///         the directory or the lock file is another user's, or a link is in the place of one. In
  ///         a directory that is read-only nothing is locked: `save` will fail there.
  ParameterStore(std::filesystem::path directory, std::uint32_t bench,
                 std::unique_ptr<FileOperations> files = system_files());
  ~ParameterStore();
  ParameterStore(const ParameterStore&) = delete;
  ParameterStore& operator=(const ParameterStore&) = delete;

  [[nodiscard]] const std::filesystem::path& directory() const noexcept { return directory_; }

  /// Reads what is stored. Changes no file but the one that a damaged one is kept aside as.
  [[nodiscard]] LoadedParameters load();

  /// Replaces what is stored; when it returns it is durable. Whatever happens meanwhile, what was
  /// stored before or the new table is there in full: the new one after an error only where it
  /// could not be taken away again, or the machine loses its power before the next save.
  /// @throws std::system_error when a file cannot be written, synced or renamed.
  void save(const ParameterTable& table);

  /// Keeps the present file under the name of a damaged one as well. A failure is logged.
  void keep_aside();

 private:
  /// The file of before a save.
  struct Replaced {
    bool was_bad = false;
    std::filesystem::path name;  ///< its name now
    bool was_there = false;
  };

  [[nodiscard]] std::filesystem::path file(const char* suffix) const;
  [[nodiscard]] std::optional<std::string> lock();
  void require_private(int opened, const std::filesystem::path& path) const;
  [[noreturn]] void refuse(const std::string& problem) const;
  [[nodiscard]] ParameterTable read(const std::filesystem::path& file);
  void load_previous(LoadedParameters& loaded);
  void put_back();
  void write_beside(std::span<const std::byte> content);
  Replaced replace();
  void take_back(const Replaced& replaced);
  [[nodiscard]] bool move_away(const std::filesystem::path& to);
  void sync_directory();

  std::filesystem::path directory_;
  std::string name_;
  std::unique_ptr<FileOperations> files_;
  int lock_ = -1;
  bool is_bad_ = false;   ///< the present file must not become the previous one
  bool is_kept_ = false;  ///< and has a second name
  bool is_away_ = false;  ///< a save was cut short: the present file has the name of the previous
};

/// @return the store of a bench in the directory that `--state`, or else $STATE_DIRECTORY of
///         systemd (the first of several), names; nothing without either.
/// @throws ConfigurationError as the constructor.
[[nodiscard]] std::unique_ptr<ParameterStore> open_parameter_store(
    const std::optional<std::string>& directory, std::uint32_t bench);

/// Gives each axis of a bench its stored parameters. An axis whose values are not all usable keeps
/// its configured ones and has fault 5530h; all axes have it when the file could not be used.
/// @return what has to be reported.
[[nodiscard]] std::vector<EventRecord> apply(const LoadedParameters& loaded,
                                             Configuration& configuration);

}  // namespace vdrive::service
