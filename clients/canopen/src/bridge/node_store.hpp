// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node.hpp"
#include "reports.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::canopen {

class StoreFile;

/// @return the text of a file of communication parameters: a line for each, such as
///         "1800:05 000003E8" (index, sub-index, value; hex), then "end 2" with their number.
[[nodiscard]] std::string text_of_parameters(const Node::Parameters& parameters);

/// Reads such a text. Lines that begin with # are left out.
/// @param problem gets the line, its text and what is wrong: no parameter of a node, or a value
///        outside of its limits; or that lines are missing
/// @return nothing when a line is wrong, or the text is not whole
[[nodiscard]] std::optional<Node::Parameters> parse_parameters(std::string_view text,
                                                               std::string& problem);

/// What the nodes of a bus have saved by 1010h: their communication parameters. Kept in memory for
/// nodes that come back, and in files where there is a directory: one file each, replaced as a
/// whole. A file that cannot be read or written is reported; then the node has its defaults, or
/// what it had saved before. The files of a bus are locked: they are those of one program.
class NodeStore {
 public:
  /// @param directory empty = no files
  /// @param bus name that the files begin with
  /// @param reports outlives this
  /// @throws std::runtime_error when another program has the lock, with directory and program
  NodeStore(std::filesystem::path directory, std::string bus, bridge::Reports& reports);

  /// @return what node `id` has saved last; empty = its defaults.
  [[nodiscard]] const Node::Parameters& find(std::uint8_t id);

  /// Saves, where it is not saved already.
  /// @return false when the file could not be written: what was saved before is still valid
  [[nodiscard]] bool save(std::uint8_t id, const Node::Parameters& parameters);

 private:
  /// What a node has saved.
  struct Saved {
    Node::Parameters parameters{};
    bool is_in_file = true;  ///< else the file has to be written in any case
  };

  void lock();
  void write(std::uint8_t id, const Node::Parameters& parameters);
  Saved& saved(std::uint8_t id);
  [[nodiscard]] std::filesystem::path file_of(std::uint8_t id) const;
  [[nodiscard]] Saved load(std::uint8_t id);
  void report(std::uint8_t id, const std::string& problem);

  const std::filesystem::path directory_;
  const std::string bus_;
  bridge::Reports& reports_;
  std::map<std::uint8_t, Saved> saved_;
  std::shared_ptr<StoreFile> lock_;
};

}  // namespace vdrive::canopen
