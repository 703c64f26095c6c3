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

/// @return the text of a file of communication parameters: one line each, such as "1800:05
///         000003E8" (index, sub-index, value; hex), then "end 2" with their number.
[[nodiscard]] std::string text_of_parameters(const Node::Parameters& parameters);

/// Parses such a text. Lines that begin with # are ignored.
/// @param problem receives the line, its text and what is wrong: not a parameter of a node, a value
///        outside its limits, or missing lines
/// @return nothing if a line is wrong or the text is incomplete
[[nodiscard]] std::optional<Node::Parameters> parse_parameters(std::string_view text,
                                                               std::string& problem);

/// The communication parameters that the nodes of a bus have saved by 1010h. Kept in memory for
/// nodes that return and, if there is a directory, in one file per node, which is replaced
/// atomically. A file that cannot be read or written is reported; the node then has its defaults,
/// or what it saved before. The files of a bus are locked, so that only one program uses them.
class NodeStore {
 public:
  /// @param directory empty = no files
  /// @param bus prefix of the file names
  /// @param reports outlives this object
  /// @throws std::runtime_error with directory and program when another program holds the lock
  NodeStore(std::filesystem::path directory, std::string bus, bridge::Reports& reports);

  /// @return the parameters that node `id` saved last; empty = its defaults.
  [[nodiscard]] const Node::Parameters& find(std::uint8_t id);

  /// Saves the parameters unless they are saved already.
  /// @return false if the file could not be written: the previous parameters remain valid
  [[nodiscard]] bool save(std::uint8_t id, const Node::Parameters& parameters);

 private:
  /// The saved parameters of a node.
  struct Saved {
    Node::Parameters parameters{};
    bool is_in_file = true;  ///< false: the file must be written even if nothing has changed
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
