// SPDX-License-Identifier: Apache-2.0
#include "security/material.hpp"

#include "tool/process.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace vdrive::test {
namespace {

const std::string kScripts = std::string(VDRIVE_SOURCE_DIR) + "/deploy/security/";

void must(const std::string& command) {
  const ShellResult result = shell(command);
  if (result.code != 0) throw std::runtime_error(command + ": " + result.text);
}

}  // namespace

ShellResult shell(const std::string& command) {
  const Finished finished = Process("/bin/bash", {"-c", command + " 2>&1"}).wait();
  return {finished.code, finished.output};
}

std::string read_file(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

Authority::Authority() {
  std::string name = (std::filesystem::temp_directory_path() / "vdrive-security-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary directory");
  root_ = name;
  directory_ = root_ / "authority";
  must(kScripts + "make_authority.sh " + directory_.string());
}

Authority::~Authority() {
  std::error_code ignored;
  std::filesystem::remove_all(root_, ignored);
}

std::filesystem::path Authority::member(const std::string& words) const {
  must(kScripts + "make_member.sh " + directory_.string() + " " + words);
  std::istringstream stream(words);
  std::string role;
  std::string name;
  stream >> role >> name;
  return directory_ / "members" / name;
}

void Authority::sign(const std::filesystem::path& xml,
                     const std::filesystem::path& document) const {
  must("openssl smime -sign -text -in " + xml.string() + " -out " + document.string() +
       " -signer " + (directory_ / "permissions_ca.pem").string() + " -inkey " +
       (directory_ / "permissions_ca_key.pem").string());
}

}  // namespace vdrive::test
