// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <initializer_list>
#include <iostream>
#include <string>

/// @return whether this process has loaded a library with one of these words in its name; prints
///         the name on standard error.
inline bool has_loaded_one_of(std::initializer_list<const char*> words) {
  std::ifstream maps("/proc/self/maps");
  bool is_loaded = false;
  bool has_libraries = false;
  for (std::string line; std::getline(maps, line);) {
    const std::string name = line.substr(line.rfind('/') + 1);
    has_libraries = has_libraries || name.starts_with("libstdc++");
    for (const char* word : words) {
      if (line.find('/') == std::string::npos || name.find(word) == std::string::npos) continue;
      std::cerr << "loaded: " << name << '\n';
      is_loaded = true;
    }
  }
  if (!has_libraries) std::cerr << "/proc/self/maps shows no library\n";
  return is_loaded || !has_libraries;
}
