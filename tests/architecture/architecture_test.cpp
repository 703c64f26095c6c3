// SPDX-License-Identifier: Apache-2.0
// The rules of the house, checked on the source tree itself.
#include "architecture/include_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
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
