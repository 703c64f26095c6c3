// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <regex.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::architecture {

/// A POSIX extended regular expression, with glibc's \b, \s and \w. Each line of the project is
/// searched for several of them; std::regex takes ten times as long in a test, which is compiled
/// without optimisation.
class Pattern {
 public:
  /// @throws std::invalid_argument if the text is not a regular expression
  explicit Pattern(const std::string& text) : compiled_(new regex_t{}, Free{}) {
    if (regcomp(compiled_.get(), text.c_str(), REG_EXTENDED) != 0) {
      throw std::invalid_argument("no regular expression: " + text);
    }
  }

  /// @return the first match, then its groups; empty if nothing matches.
  [[nodiscard]] std::vector<std::string> search(const std::string& text) const {
    std::array<regmatch_t, 4> places{};
    if (regexec(compiled_.get(), text.c_str(), places.size(), places.data(), 0) != 0) return {};
    std::vector<std::string> found;
    for (const regmatch_t& place : places) {
      if (place.rm_so < 0) break;
      found.push_back(text.substr(static_cast<std::size_t>(place.rm_so),
                                  static_cast<std::size_t>(place.rm_eo - place.rm_so)));
    }
    return found;
  }

  [[nodiscard]] bool is_in(const std::string& text) const {
    return regexec(compiled_.get(), text.c_str(), 0, nullptr, 0) == 0;
  }

  [[nodiscard]] bool is_all_of(const std::string& text) const {
    regmatch_t place{};
    return regexec(compiled_.get(), text.c_str(), 1, &place, 0) == 0 && place.rm_so == 0 &&
           place.rm_eo == static_cast<regoff_t>(text.size());
  }

 private:
  struct Free {
    void operator()(regex_t* compiled) const {
      regfree(compiled);
      delete compiled;
    }
  };

  std::shared_ptr<regex_t> compiled_;
};

}  // namespace vdrive::architecture
