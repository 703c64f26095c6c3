// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_store.hpp"

#include "node/node_object.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdrive::canopen {
namespace {

// A node has some hundred parameters, each on a line of 16 bytes.
constexpr std::size_t kLargestParameterFile = 65'536;

/// @return the digits of `number`, without a prefix.
std::string bare_hex(std::uint32_t number, std::size_t digits) {
  return hex(number, digits).substr(2);
}

/// @return whether 1010h saves this parameter of a node, and the value is allowed.
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

constexpr std::string_view kEndMark = "end ";

/// Without the count, a file truncated at the end of a line would pass as one with fewer
/// parameters.
std::string end_line(std::size_t count) {
  return std::string(kEndMark) + std::to_string(count);
}

constexpr mode_t kStoreFileMode = 0600;

void require_done(bool is_done) {
  if (!is_done) throw std::system_error(errno, std::generic_category());
}

}  // namespace

/// An open file or directory, closed by the destructor. Functions throw std::system_error when a
/// system call fails.
class StoreFile final {
 public:
  /// @param flags as for open(2); a new file is accessible to this user only
  StoreFile(const std::filesystem::path& path, int flags)
      // NOLINTNEXTLINE(*-vararg): open(2) is variadic
      : number_(::open(path.c_str(), flags | O_CLOEXEC, kStoreFileMode)) {
    require_done(number_ >= 0);
  }

  /// Unlocks explicitly: a flock belongs to all processes that share the open file, so a process
  /// forked from this one would keep it.
  ~StoreFile() {
    static_cast<void>(::flock(number_, LOCK_UN));  // no effect without a lock
    ::close(number_);
  }

  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  void write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t written = ::write(number_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      require_done(written > 0);
      text.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  void sync() const { require_done(::fsync(number_) == 0); }

  /// @return false if another process holds the lock (flock), which is released with this object.
  [[nodiscard]] bool try_lock() const {
    int result = 0;
    do {
      result = ::flock(number_, LOCK_EX | LOCK_NB);
    } while (result != 0 && errno == EINTR);
    require_done(result == 0 || errno == EWOULDBLOCK);
    return result == 0;
  }

  /// Empties the file.
  void clear() const { require_done(::ftruncate(number_, 0) == 0); }

  /// @return the first line of at most 200 bytes.
  [[nodiscard]] std::string first_line() const {
    std::array<char, 200> text{};
    const ssize_t count = ::pread(number_, text.data(), text.size(), 0);
    require_done(count >= 0);
    const std::string_view read(text.data(), static_cast<std::size_t>(count));
    return std::string(read.substr(0, read.find('\n')));
  }

 private:
  const int number_;
};

namespace {

/// Replaces a file atomically: after a failure at any point it is either the old or the new one.
/// @throws std::system_error
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
  return text + end_line(parameters.size()) + "\n";
}

std::optional<Node::Parameters> parse_parameters(std::string_view text, std::string& problem) {
  Node::Parameters parameters;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.empty() || line.starts_with('#')) continue;
    if (line == end_line(parameters.size()) && text.empty()) return parameters;
    const auto parameter = parse_parameter(line);
    if (!parameter || !is_parameter(parameter->first, parameter->second)) {
      problem =
          "line " + std::to_string(number) + ", " + in_quotes(line) +
          ", is not a parameter of a node, such as 1800:05 000003E8, or its value is out of range";
      return std::nullopt;
    }
    parameters.insert_or_assign(parameter->first, parameter->second);
  }
  problem = "it is incomplete: its last line must be " + in_quotes(end_line(parameters.size())) +
            ", with the number of parameters before it";
  return std::nullopt;
}

NodeStore::NodeStore(std::filesystem::path directory, std::string bus, bridge::Reports& reports)
    : directory_(std::move(directory)), bus_(std::move(bus)), reports_(reports) {
  if (directory_.empty()) return;
  try {
    lock();
  } catch (const std::system_error& error) {  // a later save tries again
    reports_.report(bridge::Severity::error, bus_,
                    "state directory " + directory_.string() +
                        ": not locked, 1010h is refused: " + error.code().message());
  }
}

void NodeStore::lock() {
  std::filesystem::create_directories(directory_);
  const std::filesystem::path path = directory_ / (bus_ + ".nodes.lock");
  auto file = std::make_shared<StoreFile>(path, O_RDWR | O_CREAT | O_NOFOLLOW);
  if (!file->try_lock()) {
    const std::string owner = file->first_line();
    throw std::runtime_error("state directory " + in_quotes(directory_.string()) + ": " +
                             (owner.empty() ? "another process" : escaped(owner)) + " has locked " +
                             path.filename().string() +
                             ": end it, or give this program another directory (--state)");
  }
  file->clear();
  file->write("process " + std::to_string(::getpid()) + "\n");
  lock_ = std::move(file);
}

std::filesystem::path NodeStore::file_of(std::uint8_t id) const {
  return directory_ / (bus_ + ".node-" + std::to_string(id) + ".parameters");
}

void NodeStore::report(std::uint8_t id, const std::string& problem) {
  reports_.report(bridge::Severity::error, bus_ + ": node " + std::to_string(id),
                  file_of(id).string() + ": " + problem);
}

NodeStore::Saved& NodeStore::saved(std::uint8_t id) {
  const auto known = saved_.find(id);
  if (known != saved_.end()) return known->second;
  return saved_.emplace(id, directory_.empty() ? Saved{} : load(id)).first->second;
}

const Node::Parameters& NodeStore::find(std::uint8_t id) {
  return saved(id).parameters;
}

NodeStore::Saved NodeStore::load(std::uint8_t id) {
  Saved unusable{.is_in_file = false};
  std::ifstream stream(file_of(id), std::ios::binary);
  if (!stream) {
    if (errno == ENOENT) return {};
    report(id, "cannot be read: " + std::generic_category().message(errno));
    return unusable;
  }
  std::string text(kLargestParameterFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (stream.bad() || text.size() > kLargestParameterFile) {
    report(id, "cannot be read, or has more than " + std::to_string(kLargestParameterFile) +
                   " bytes: the node has its defaults");
    return unusable;
  }
  std::string problem;
  auto parameters = parse_parameters(text, problem);
  if (parameters) return {.parameters = std::move(*parameters)};
  report(id, problem + ": the node has its defaults");
  return unusable;
}

bool NodeStore::save(std::uint8_t id, const Node::Parameters& parameters) {
  Saved& known = saved(id);
  if (known.is_in_file && known.parameters == parameters) return true;
  try {
    // After a failure the file may be the old or the new one.
    known.is_in_file = false;
    if (!directory_.empty()) write(id, parameters);
  } catch (const std::system_error& error) {  // errors of std::filesystem too
    report(id, "cannot be written: " + error.code().message());
    return false;
  } catch (const std::runtime_error& error) {
    report(id, std::string("cannot be written: ") + error.what());
    return false;
  }
  known = {.parameters = parameters};
  return true;
}

void NodeStore::write(std::uint8_t id, const Node::Parameters& parameters) {
  if (!lock_) lock();
  replace_file(file_of(id), text_of_parameters(parameters));
}

}  // namespace vdrive::canopen
