// SPDX-License-Identifier: Apache-2.0
#include "completion.hpp"

#include <vector>

namespace vdrive::tool {
namespace {

void append(std::string& list, const std::string& word) {
  if (!list.empty()) list += ' ';
  list += word;
}

/// @return the names of its options, such as "-h --help --json".
std::string options_of(const CLI::App& app) {
  std::string names;
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_snames()) append(names, "-" + name);
    for (const std::string& name : option->get_lnames()) append(names, "--" + name);
  }
  return names;
}

/// @return the options that take a value, as a pattern of `case`.
std::string valued_options_of(const CLI::App& app) {
  std::string pattern;
  for (const CLI::Option* const option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    for (const std::string& name : option->get_lnames()) {
      pattern += (pattern.empty() ? "--" : "|--") + name;
    }
  }
  return pattern;
}

std::string words_of(const CLI::App& app) {
  std::string words;
  for (const CLI::App* const word : app.get_subcommands({})) append(words, word->get_name());
  return words;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  const std::string& name = app.get_name();
  std::string cases;
  for (const CLI::App* const word : app.get_subcommands({})) {
    cases += "    " + word->get_name() + ") choices=\"" + options_of(*word) + " $global\" ;;\n";
  }
  // The first argument that is neither an option nor the value of one is the word.
  return "# bash completion for " + name + ", made by: " + name + " completion bash\n_" + name +
         "() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} global=\"" +
         options_of(app) +
         "\" word= choices= i\n"
         "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
         "    case ${COMP_WORDS[i]} in\n"
         "    " +
         valued_options_of(app) +
         ") ((++i)) ;;\n"
         "    -*) ;;\n"
         "    *) word=${COMP_WORDS[i]}; break ;;\n"
         "    esac\n"
         "  done\n"
         "  case $word in\n"
         "    \"\") choices=\"" +
         words_of(app) + " $global\" ;;\n" + cases +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$choices\" -- \"$current\"))\n"
         "}\n"
         "complete -o default -F _" +
         name + " " + name + "\n";
}

}  // namespace vdrive::tool
