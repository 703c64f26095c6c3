// SPDX-License-Identifier: Apache-2.0
// The rules of the project, checked on the source tree itself.
#include "architecture/include_rules.hpp"
#include "architecture/pattern.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::architecture {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::StartsWith;

const fs::path kRoot = VDRIVE_SOURCE_DIR;

struct SourceFile {
  std::string path;
  std::string text;
};

std::string read(const fs::path& path) {
  std::string text(fs::file_size(path), '\0');
  std::ifstream(path, std::ios::binary)
      .read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
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
  for (const SourceFile& file : files) EXPECT_THAT(check_source(file.path, file.text), IsEmpty());
}

/// Whether the build generates the header.
bool is_generated(const std::string& name) {
  return name.starts_with("vdrive_messages") || name.starts_with("ros_messages") ||
         name == "configuration/preset_texts.hpp";
}

/// The headers of the project as a file includes them, such as "byte_ring.hpp" and
/// "vdrive/axis_bank.hpp".
std::vector<std::string> own_includes(const std::string& text) {
  constexpr std::string_view kBefore = "\n#include \"";
  std::vector<std::string> names;
  for (std::size_t at = text.find(kBefore); at != std::string::npos; at = text.find(kBefore, at)) {
    at += kBefore.size();
    const std::string name = text.substr(at, text.find('"', at) - at);
    if (!is_generated(name)) names.push_back(name);
  }
  return names;
}

bool is_public(const std::string& name) {
  return name.starts_with("vdrive/");
}

std::string room_of(const std::string& path) {
  return path.substr(0, path.find('/') + 1);
}

std::string last_part(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

// The path of a service header does not show its owner.
TEST(Architecture, PrivateHeadersAreIncludedInTheirOwnRoomOnly) {
  const std::vector<SourceFile> files = sources();
  std::vector<std::string> paths;
  for (const SourceFile& file : files) {
    if (file.path.ends_with(".hpp")) paths.push_back(file.path);
  }
  for (const SourceFile& file : files) {
    if (file.path.starts_with("tests/")) continue;
    for (const std::string& name : own_includes(file.text)) {
      EXPECT_TRUE(is_public(name) || reaches_private_header(file.path, name, paths))
          << file.path << " includes " << name;
    }
  }
}

/// The headers that each file includes, by their paths.
using IncludeGraph = std::map<std::string, std::vector<std::string>>;

IncludeGraph include_graph(const std::vector<SourceFile>& files) {
  // Headers by the last part of their path; few share a name.
  std::multimap<std::string, const SourceFile*> headers;
  for (const SourceFile& file : files) headers.emplace(last_part(file.path), &file);
  IncludeGraph graph;
  for (const SourceFile& file : files) {
    auto& included = graph[file.path];
    for (const std::string& name : own_includes(file.text)) {
      const auto [begin, end] = headers.equal_range(last_part(name));
      for (auto header = begin; header != end; ++header) {
        const std::string& path = header->second->path;
        const bool is_meant = is_public(name) || room_of(path) == room_of(file.path) ||
                              file.path.starts_with("tests/");
        if (is_meant && path.ends_with("/" + name)) included.push_back(path);
      }
    }
  }
  return graph;
}

TEST(Architecture, NoHeaderIncludesItselfThroughOthers) {
  IncludeGraph graph = include_graph(sources());
  ASSERT_GT(graph.size(), 100U);
  // A file without remaining includes is not part of a cycle.
  const auto is_free = [&](const IncludeGraph::value_type& file) {
    return std::ranges::none_of(file.second, [&](const std::string& included) {
      return graph.contains(included);
    });
  };
  while (std::erase_if(graph, is_free) > 0) {
  }
  EXPECT_THAT(graph, IsEmpty());
}

/// @return the header and all files that include it, directly or through others.
std::set<std::string> reaching(const std::string& header, const IncludeGraph& graph) {
  std::set<std::string> found{header};
  const auto includes_found = [&](const IncludeGraph::value_type& file) {
    return std::ranges::any_of(file.second, [&](const std::string& included) {
      return found.contains(included);
    });
  };
  for (std::size_t before = 0; before != found.size();) {
    before = found.size();
    for (const auto& file : graph) {
      if (includes_found(file)) found.insert(file.first);
    }
  }
  return found;
}

/// @return how many of the files are compiled: sources, and headers that are compiled alone.
std::ptrdiff_t units_of(const std::set<std::string>& files) {
  return std::ranges::count_if(files, [](const std::string& path) {
    return path.ends_with(".cpp") || path.find("/include/") != std::string::npos;
  });
}

/// @return the ten headers of `files` that the most compiled units include, directly or through
///         others, with the number of units.
std::string ways_to(const std::set<std::string>& files, const IncludeGraph& graph) {
  std::multimap<std::ptrdiff_t, std::string, std::greater<>> headers;
  for (const std::string& path : files) {
    if (path.ends_with(".hpp")) headers.emplace(units_of(reaching(path, graph)), path);
  }
  std::ostringstream text;
  std::size_t lines = 0;
  for (const auto& [units, path] : headers) {
    if (++lines > 10) break;
    text << "\n  " << units << " through " << path;
  }
  return text.str();
}

TEST(Architecture, AnObjectRowCompilesAtMost200Units) {
  const IncludeGraph graph = include_graph(sources());
  const std::set<std::string> files =
      reaching("core/include/vdrive/dictionary/object_table.hpp", graph);
  ASSERT_TRUE(files.contains("core/src/drive/tick.cpp"));
  EXPECT_LE(units_of(files), 200) << ways_to(files, graph);
}

std::string module_of(const std::string& path) {
  return path.substr(0, path.rfind('.'));
}

/// Which module uses which, by their paths below a folder. A header and its source form one module,
/// so that a cycle through a source counts, too.
using ModuleGraph = std::map<std::string, std::set<std::string>>;

/// @param folder with a trailing slash; its files include each other by their path below it
ModuleGraph modules_below(const std::string& folder, const std::vector<SourceFile>& files) {
  ModuleGraph modules;
  for (const SourceFile& file : files) {
    if (!file.path.starts_with(folder)) continue;
    const std::string module = module_of(file.path.substr(folder.size()));
    std::set<std::string>& used = modules[module];
    for (const std::string& name : own_includes(file.text)) {
      if (!is_public(name)) used.insert(module_of(name));
    }
    used.erase(module);
  }
  return modules;
}

/// @return the modules that form cycles or use one that does: those left after repeatedly removing
///         all that use none of the others.
ModuleGraph circles_of(ModuleGraph modules) {
  const auto is_free = [&](const auto& entry) {
    return std::ranges::none_of(entry.second, [&](const std::string& used) {
      return modules.contains(used);
    });
  };
  while (std::erase_if(modules, is_free) > 0) {
  }
  return modules;
}

TEST(Architecture, NoModuleOfTheServiceUsesItselfThroughOthers) {
  const ModuleGraph modules = modules_below("service/src/", sources());
  ASSERT_GT(modules.size(), 50U);
  EXPECT_THAT(circles_of(modules), IsEmpty());
}

TEST(Architecture, NoModuleOfTheToolUsesItselfThroughOthers) {
  const ModuleGraph modules = modules_below("clients/tool/", sources());
  ASSERT_GT(modules.size(), 50U);
  EXPECT_THAT(circles_of(modules), IsEmpty());
}

TEST(Architecture, NoModuleOfTheClientUsesItselfThroughOthers) {
  const ModuleGraph modules = modules_below("clients/src/", sources());
  ASSERT_GT(modules.size(), 40U);
  EXPECT_THAT(circles_of(modules), IsEmpty());
}

TEST(Architecture, NoModuleOfTheBridgeToCanopenUsesItselfThroughOthers) {
  const ModuleGraph modules = modules_below("clients/canopen/src/", sources());
  ASSERT_GT(modules.size(), 20U);
  EXPECT_THAT(circles_of(modules), IsEmpty());
}

TEST(Architecture, NoModuleOfTheJudgeUsesItselfThroughOthers) {
  const ModuleGraph modules = modules_below("clients/judge/src/", sources());
  ASSERT_GT(modules.size(), 10U);
  EXPECT_THAT(circles_of(modules), IsEmpty());
}

TEST(Modules, FormACircleAlsoThroughTheirSources) {
  const std::vector<SourceFile> files{{"tool/a/one.cpp", "\n#include \"b/two.hpp\""},
                                      {"tool/b/two.cpp", "\n#include \"a/one.hpp\""},
                                      {"tool/b/three.hpp", "\n#include \"b/four.hpp\""},
                                      {"tool/b/four.hpp", ""}};

  EXPECT_THAT(
      circles_of(modules_below("tool/", files)),
      ElementsAre(Pair("a/one", ElementsAre("b/two")), Pair("b/two", ElementsAre("a/one"))));
}

/// Names of the functions in the unnamed namespaces of a source: definitions that begin
/// in column 1.
std::set<std::string> own_functions(const std::string& text) {
  static const Pattern function(R"re(^[A-Za-z_][^(=;]*[ &*>](\w+)\()re");
  std::set<std::string> names;
  std::istringstream lines(text);
  bool is_inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("namespace {")) is_inside = true;
    if (line.starts_with("}  // namespace")) is_inside = false;
    if (!is_inside) continue;
    const std::vector<std::string> match = function.search(line);
    if (!match.empty()) names.insert(match[1]);
  }
  return names;
}

// If an unnamed namespace has two functions of one name, the compiler takes the one that fits the
// arguments better, which may be that of the other source.
TEST(Architecture, UnnamedFunctionsOfSourcesThatAreCompiledTogetherHaveDifferentNames) {
  std::size_t targets = 0;
  for (const fs::directory_entry& list :
       fs::directory_iterator(fs::path(VDRIVE_BINARY_DIR) / "compiled_together")) {
    ++targets;
    std::map<std::string, std::string> owners;
    std::istringstream paths(read(list.path()));
    for (std::string path; std::getline(paths, path);) {
      for (const std::string& name : own_functions(read(path))) {
        const auto [owner, is_new] = owners.try_emplace(name, path);
        EXPECT_TRUE(is_new) << list.path().stem() << ": " << name << " is in " << owner->second
                            << " and in " << path << ": rename one, or compile one APART";
      }
    }
  }
  EXPECT_GT(targets, 10U) << "the lists are written by vdrive_compile_together";
}

/// The libraries that the targets of the tree link, by their names without "vdrive_"; CMake writes
/// a file for each target.
using LinkGraph = std::map<std::string, std::set<std::string>>;

/// @return `name` as links use it: vdrive::core and vdrive_core are "core".
std::string short_name(const std::string& name) {
  static const Pattern parts(R"(^(\$<BUILD_INTERFACE:)?(vdrive(::|_))?)");
  const std::string rest = name.substr(parts.search(name).at(0).size());
  return rest.ends_with('>') ? rest.substr(0, rest.size() - 1) : rest;
}

LinkGraph link_graph() {
  LinkGraph graph;
  for (const fs::directory_entry& list :
       fs::directory_iterator(fs::path(VDRIVE_BINARY_DIR) / "links")) {
    std::set<std::string>& linked = graph[short_name(list.path().stem().string())];
    std::istringstream names(read(list.path()));
    for (std::string name; std::getline(names, name);) {
      const bool is_dds = name == "fastrtps" || name == "fastdds";  // depending on the version
      if (!name.empty()) linked.insert(is_dds ? "Fast DDS" : short_name(name));
    }
  }
  return graph;
}

/// The table of docs/architecture.md, "Who links what".
LinkGraph documented_links() {
  static const Pattern row(R"(^\| `([^`]+)` \|[^|]*\| ([^|]+) \|$)");
  LinkGraph graph;
  std::istringstream lines(read(kRoot / "docs/architecture.md"));
  bool is_inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("| target | has | links |")) is_inside = true;
    if (line.empty()) is_inside = false;
    const std::vector<std::string> match =
        is_inside ? row.search(line) : std::vector<std::string>{};
    if (match.empty()) continue;
    std::istringstream names(match[2]);
    for (std::string name; std::getline(names >> std::ws, name, ',');) {
      graph[short_name(match[1])].insert(name);
    }
  }
  return graph;
}

/// Programs (their libraries have rows), examples, generated code and programs of the build itself.
bool needs_no_row(const std::string& target) {
  static const std::set<std::string> programs{"vdrive",         "vdrived",     "vdrive-canopen",
                                              "vdrive-gateway", "vdrive-ros2", "make_page_tables",
                                              "fill_template"};
  return programs.contains(target) || target.starts_with("example_") ||
         target.ends_with("messages");
}

TEST(Architecture, LibrariesLinkWhatTheirRowOfTheDocumentSays) {
  const LinkGraph documented = documented_links();
  LinkGraph graph = link_graph();
  std::erase_if(graph, [](const LinkGraph::value_type& target) {
    return needs_no_row(target.first);
  });
  for (const auto& [target, linked] : graph) {
    ASSERT_TRUE(documented.contains(target)) << target << " has no row in docs/architecture.md";
    EXPECT_EQ(linked, documented.at(target)) << target;
  }
  for (const auto& [target, linked] : documented) {
    const bool is_optional = target == "python";  // built only if pybind11 is found
    EXPECT_TRUE(is_optional || graph.contains(target)) << target << " is no target";
  }
}

/// @return everything that `target` links, directly or through others.
std::set<std::string> reached_from(const std::string& target, const LinkGraph& graph) {
  std::set<std::string> reached{target};
  std::vector<std::string> open{target};
  while (!open.empty()) {
    const auto links = graph.find(open.back());
    open.pop_back();
    if (links == graph.end()) continue;
    for (const std::string& name : links->second) {
      if (reached.insert(name).second) open.push_back(name);
    }
  }
  return reached;
}

TEST(Architecture, WhatWorksWithoutANetworkLinksNoLibraryOfIt) {
  const LinkGraph graph = link_graph();
  const std::set<std::string> of_the_network{
      "Fast DDS",           "OpenSSL::Crypto",    "tinyxml2::tinyxml2", "prometheus-cpp::core",
      "PkgConfig::seccomp", "PkgConfig::systemd", "CLI11::CLI11"};
  ASSERT_THAT(reached_from("service", graph), testing::IsSupersetOf(of_the_network));
  for (const char* target : {"bench", "recording", "process", "python"}) {
    for (const std::string& name : reached_from(target, graph)) {
      EXPECT_FALSE(of_the_network.contains(name)) << target << " links " << name;
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

// kill(2) takes process 0 for the caller's process group: with 0 for a process that was not found,
// a test would stop or end ctest and its parent.
TEST(Architecture, TestsSendSignalsOnlyThroughTheFunctionThatRefusesGroupsOfProcesses) {
  static const Pattern call(R"((^|[^A-Za-z0-9_.>])(kill|killpg)\(([^)2]|2[^)]|$))");
  for (const SourceFile& file : sources()) {
    if (!file.path.starts_with("tests/") || file.path == "tests/support/signals.hpp") continue;
    std::istringstream lines(file.text);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_FALSE(call.is_in(line)) << file.path << ": " << line;
    }
  }
}

}  // namespace
}  // namespace vdrive::architecture
