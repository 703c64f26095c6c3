// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_store.hpp"

#include "node/node_object.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <system_error>
#include <utility>

namespace vdrive::canopen {
namespace {

// A node has some hundred parameters; a line of one has 16 bytes.
constexpr std::size_t kLargestParameterFile = 65'536;

/// @return the digits of `number`, without a prefix.
std::string bare_hex(std::uint32_t number, std::size_t digits) {
  return hex(number, digits).substr(2);
}

/// @return whether 1010h saves this value of a node.
bool is_parameter(ObjectAddress address, std::uint32_t value) {
  const NodeObject* const object = find_node_object(address);
  return object != nullptr && object->owner == ObjectOwner::node &&
         object->access == NodeAccess::read_write &&
         object->data_type != NodeDataType::visible_string && value >= object->lower_limit &&
         value <= object->upper_limit;
}

/// @return the parameter of a line "IIII:SS VVVVVVVV", or nothing.
std::optional<Node::Parameters::value_type> parse_parameter(std::string_view line) {
  constexpr std::size_t kColon = 4;
  constexpr std::size_t kBlank = 7;
  if (line.size() <= kBlank || line[kColon] != ':' || line[kBlank] != ' ') return std::nullopt;
  const auto index = parse_digits<std::uint16_t>(line.substr(0, kColon), 16);
  const auto subindex = parse_digits<std::uint8_t>(line.substr(kColon + 1, 2), 16);
  const auto value = parse_digits<std::uint32_t>(line.substr(kBlank + 1), 16);
  if (!index || !subindex || !value) return std::nullopt;
  return Node::Parameters::value_type{{*index, *subindex}, *value};
}

/// An open file, closed at its end.
class StoreFile {
 public:
  /// @throws std::system_error, as every function here does
  StoreFile(const std::filesystem::path& path, int flags)
      // NOLINTNEXTLINE(*-vararg): what the system offers
      : number_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {
    require(number_ >= 0);
  }

  ~StoreFile() { ::close(number_); }

  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  void write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t written = ::write(number_, text.data(), text.size());
      require(written > 0);
      text.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  void sync() const { require(::fsync(number_) == 0); }

 private:
  static void require(bool is_done) {
    if (!is_done) throw std::system_error(errno, std::generic_category());
  }

  int number_;
};

/// After a failure at any place the file is the old one or the new one.
void replace_file(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path next = path.string() + ".new";
  {
    const StoreFile file(next, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW);
    file.write(text);
    file.sync();
  }
  std::filesystem::rename(next, path);
  const StoreFile directory(path.parent_path(), O_RDONLY | O_DIRECTORY);
  directory.sync();
}

}  // namespace

std::string text_of_parameters(const Node::Parameters& parameters) {
  std::string text = "# Communication parameters of a CANopen node, saved by 1010h\n";
  for (const auto& [address, value] : parameters) {
    text += bare_hex(address.index, 4) + ":" + bare_hex(address.subindex, 2) + " " +
            bare_hex(value, 8) + "\n";
  }
  return text;
}

std::optional<Node::Parameters> parse_parameters(std::string_view text, std::string& problem) {
  Node::Parameters parameters;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.empty() || line.starts_with('#')) continue;
    const auto parameter = parse_parameter(line);
    if (!parameter || !is_parameter(parameter->first, parameter->second)) {
      problem = "line " + std::to_string(number) + ", " + in_quotes(line) +
                ", is no parameter of a node, such as 1800:05 000003E8, or its value is outside "
                "of its limits";
      return std::nullopt;
    }
    parameters.insert_or_assign(parameter->first, parameter->second);
  }
  return parameters;
}

NodeStore::NodeStore(std::filesystem::path directory, std::string bus, bridge::Reports& reports)
    : directory_(std::move(directory)), bus_(std::move(bus)), reports_(reports) {}

std::filesystem::path NodeStore::file_of(std::uint8_t id) const {
  return directory_ / (bus_ + ".node-" + std::to_string(id) + ".parameters");
}

void NodeStore::report(std::uint8_t id, const std::string& problem) {
  reports_.report(bridge::Severity::error, bus_ + ": node " + std::to_string(id),
                  file_of(id).string() + ": " + problem);
}

const Node::Parameters& NodeStore::find(std::uint8_t id) {
  const auto known = saved_.find(id);
  if (known != saved_.end()) return known->second;
  return saved_.emplace(id, directory_.empty() ? Node::Parameters{} : load(id)).first->second;
}

Node::Parameters NodeStore::load(std::uint8_t id) {
  std::ifstream stream(file_of(id), std::ios::binary);
  if (!stream) {
    if (errno != ENOENT) report(id, "cannot be read: " + std::generic_category().message(errno));
    return {};
  }
  std::string text(kLargestParameterFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (stream.bad() || text.size() > kLargestParameterFile) {
    report(id, "cannot be read, or has more than " + std::to_string(kLargestParameterFile) +
                   " bytes: the node has its defaults");
    return {};
  }
  std::string problem;
  auto parameters = parse_parameters(text, problem);
  if (parameters) return std::move(*parameters);
  report(id, problem + ": the node has its defaults");
  return {};
}

void NodeStore::save(std::uint8_t id, const Node::Parameters& parameters) {
  Node::Parameters& saved = saved_[id];
  if (saved == parameters) return;
  saved = parameters;
  if (directory_.empty()) return;
  try {
    std::filesystem::create_directories(directory_);
    replace_file(file_of(id), text_of_parameters(parameters));
  } catch (const std::system_error& error) {  // those of files are such, too
    report(id, "cannot be written, the parameters are kept until this program ends: " +
                   error.code().message());
  }
}

}  // namespace vdrive::canopen
