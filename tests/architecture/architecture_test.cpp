// SPDX-License-Identifier: Apache-2.0
// The rules of the house, checked on the source tree itself.
#include "architecture/include_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace vdrive::architecture {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;
using testing::StartsWith;

const fs::path kRoot = VDRIVE_SOURCE_DIR;

struct SourceFile {
  std::string path;
  std::string text;
};

std::string read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool is_source(const fs::path& path) {
  const fs::path extension = path.extension();
  return extension == ".cpp" || extension == ".hpp" || extension == ".h" || extension == ".c" ||
         extension == ".inc" || extension == ".idl";
}

std::vector<SourceFile> sources() {
  std::vector<SourceFile> files;
  for (const char* room : {"core", "idl", "service", "clients", "tests", "deploy"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / room)) {
      if (entry.is_regular_file() && is_source(entry.path())) {
        files.push_back(
            {entry.path().lexically_relative(kRoot).generic_string(), read(entry.path())});
      }
    }
  }
  return files;
}

TEST(Architecture, RoomsIncludeOnlyWhatTheirRowOfTheTableAllows) {
  const std::vector<SourceFile> files = sources();
  ASSERT_GT(files.size(), 10U) << "no sources below " << kRoot;
  for (const SourceFile& file : files) {
    EXPECT_THAT(check_source(file.path, file.text), IsEmpty());
  }
}

/// The name of a header that lies in the including room, such as "byte_ring.hpp".
std::vector<std::string> private_includes(const std::string& text) {
  static const std::regex pattern(R"re(\n#include "([^"]+)")re");
  std::vector<std::string> names;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    const std::string name = (*match)[1];
    if (!name.starts_with("vdrive")) names.push_back(name);
  }
  return names;
}

std::string room_of(const std::string& path) {
  return path.substr(0, path.find('/') + 1);
}

// The headers of the service have no path that tells whose they are.
TEST(Architecture, PrivateHeadersAreIncludedInTheirOwnRoomOnly) {
  const std::vector<SourceFile> files = sources();
  for (const SourceFile& file : files) {
    if (file.path.starts_with("tests/")) continue;
    for (const std::string& name : private_includes(file.text)) {
      const bool is_in_room = std::ranges::any_of(files, [&](const SourceFile& header) {
        return header.path.starts_with(room_of(file.path)) && header.path.ends_with("/" + name);
      });
      EXPECT_TRUE(is_in_room) << file.path << " includes " << name;
    }
  }
}

TEST(Architecture, TopLevelOfTheRepositoryHasTheRoomsAndNothingElse) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(kRoot)) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(check_top_level(names), IsEmpty());
}

TEST(Architecture, EachSourceFileStartsWithItsLicence) {
  for (const SourceFile& file : sources()) {
    EXPECT_THAT(file.text, StartsWith("// SPDX-License-Identifier: Apache-2.0\n")) << file.path;
  }
}

TEST(Architecture, EachHeaderIsGuardedByPragmaOnce) {
  for (const SourceFile& file : sources()) {
    if (!file.path.ends_with(".hpp")) continue;
    EXPECT_NE(file.text.find("\n#pragma once\n"), std::string::npos) << file.path;
  }
}

}  // namespace
}  // namespace vdrive::architecture
