// SPDX-License-Identifier: Apache-2.0
// The documents of the closed mode (DDS Security 1.1, sections 9.4.1.2 and 9.4.1.3).
#include "vdrive/wire/security.hpp"

#include "dds/credentials.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/topics.hpp"

#include <tinyxml2.h>

#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <iomanip>
#include <optional>
#include <sstream>

namespace vdrive::wire {
namespace {

using Element = tinyxml2::XMLElement;

bool matches(const std::string& pattern, const std::string& topic) {
  return fnmatch(pattern.c_str(), topic.c_str(), 0) == 0;
}

/// A signed document, read element by element; every error names the file.
class Document {
 public:
  Document(const std::filesystem::path& ca, std::filesystem::path file) : file_(std::move(file)) {
    const std::string text = verified_text(ca, file_);
    if (xml_.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
      refuse("is not valid XML: " + escaped(xml_.ErrorStr(), kShownOfMessage));
    }
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw NetworkError("network security: " + escaped(file_.string(), kShownOfMessage) + ": " +
                       what);
  }

  /// @return the element with this name directly below <dds>.
  [[nodiscard]] const Element& part(const char* name) const {
    const Element* const root = xml_.FirstChildElement("dds");
    if (root == nullptr) refuse("has no <dds>");
    return child(*root, name);
  }

  [[nodiscard]] const Element& child(const Element& parent, const char* name) const {
    const Element* const found = parent.FirstChildElement(name);
    if (found == nullptr) refuse_missing(name, parent);
    return *found;
  }

  /// A separate function: where g++ 12 inlines these concatenations, it warns about bounds that are
  /// in fact kept (GCC bug 105651).
  [[noreturn]] void refuse_missing(std::string_view name, const Element& parent) const {
    refuse(std::string("has no <").append(name).append("> in <").append(parent.Name()).append(">"));
  }

  [[nodiscard]] std::string text(const Element& parent, const char* name) const {
    const char* const content = child(parent, name).GetText();
    return content == nullptr ? "" : content;
  }

  [[nodiscard]] bool truth(const Element& parent, const char* name) const {
    const std::string value = text(parent, name);
    return value == "true" || value == "TRUE" || value == "1";
  }

  /// @return whether the <domains> of `rule` contain `domain`.
  [[nodiscard]] bool holds(const Element& rule, std::uint32_t domain) const {
    const Element& domains = child(rule, "domains");
    for (const Element* entry = domains.FirstChildElement(); entry != nullptr;
         entry = entry->NextSiblingElement()) {
      const bool is_range = std::string_view(entry->Name()) == "id_range";
      const Element* const lowest = is_range ? entry->FirstChildElement("min") : entry;
      const Element* const highest = is_range ? entry->FirstChildElement("max") : entry;
      const unsigned from = lowest == nullptr ? 0 : lowest->UnsignedText(UINT32_MAX);
      const unsigned to = highest == nullptr ? UINT32_MAX : highest->UnsignedText(0);
      if (domain >= from && domain <= to) return true;
    }
    return false;
  }

 private:
  std::filesystem::path file_;
  tinyxml2::XMLDocument xml_;
};

// ---- governance --------------------------------------------------------------------------------

void require(const Document& document, const Element& rule, const char* name, bool wanted) {
  if (document.truth(rule, name) != wanted) {
    document.refuse(std::string(name) + " must be " + (wanted ? "TRUE" : "FALSE") +
                    "; otherwise the bench is not protected");
  }
}

void require_protection(const Document& document, const Element& rule, const char* name,
                        bool must_encrypt) {
  const std::string kind = document.text(rule, name);
  const bool is_encrypted = kind.starts_with("ENCRYPT");
  if (!is_encrypted && (must_encrypt || !kind.starts_with("SIGN"))) {
    document.refuse(std::string(name) + " is " + escaped(kind) + ", must be " +
                    (must_encrypt ? "" : "SIGN or ") +
                    "ENCRYPT; otherwise the bench is not protected");
  }
}

void check_topic(const Document& document, const Element& rules, const std::string& topic) {
  for (const Element* rule = rules.FirstChildElement("topic_rule"); rule != nullptr;
       rule = rule->NextSiblingElement("topic_rule")) {
    if (!matches(document.text(*rule, "topic_expression"), topic)) continue;
    require(document, *rule, "enable_discovery_protection", true);
    require(document, *rule, "enable_read_access_control", true);
    require(document, *rule, "enable_write_access_control", true);
    require_protection(document, *rule, "data_protection_kind", true);
    return;
  }
  document.refuse("has no <topic_rule> for topic " + topic);
}

void check_governance(const Document& document, std::uint32_t domain) {
  const Element& rules = document.part("domain_access_rules");
  const Element* rule = rules.FirstChildElement("domain_rule");
  while (rule != nullptr && !document.holds(*rule, domain)) {
    rule = rule->NextSiblingElement("domain_rule");
  }
  if (rule == nullptr) document.refuse("has no <domain_rule> for domain " + std::to_string(domain));
  require(document, *rule, "allow_unauthenticated_participants", false);
  require(document, *rule, "enable_join_access_control", true);
  require_protection(document, *rule, "discovery_protection_kind", true);
  // Liveliness is part of messages that are encrypted completely.
  require_protection(document, *rule, "liveliness_protection_kind", false);
  // The guard recognises an encrypted message by its three parts; a signed one may have anything in
  // between.
  require_protection(document, *rule, "rtps_protection_kind", true);
  for (const TopicTraits& traits : kTopics) {
    check_topic(document, document.child(*rule, "topic_access_rules"),
                std::string(kTopicPrefix) + std::string(traits.name));
  }
}

// ---- permissions -------------------------------------------------------------------------------

std::optional<std::time_t> parse_time(const std::string& text) {
  std::tm fields{};
  std::istringstream stream(text);
  if (!(stream >> std::get_time(&fields, "%Y-%m-%dT%H:%M:%S"))) return std::nullopt;
  return timegm(&fields);
}

void check_validity(const Document& document, const Element& grant) {
  const Element& validity = document.child(grant, "validity");
  const std::string begin = document.text(validity, "not_before");
  const std::string end = document.text(validity, "not_after");
  const auto from = parse_time(begin);
  const auto to = parse_time(end);
  if (!from || !to) {
    document.refuse("has a <validity> that is not a date such as 2026-01-31T00:00:00");
  }
  const std::time_t now = std::time(nullptr);
  if (now > *to) document.refuse("expired at " + escaped(end));
  if (now < *from) document.refuse("is not valid before " + escaped(begin));
}

const Element& grant_of(const Document& document, const std::string& subject) {
  std::string others;
  const Element& permissions = document.part("permissions");
  for (const Element* grant = permissions.FirstChildElement("grant"); grant != nullptr;
       grant = grant->NextSiblingElement("grant")) {
    const std::string name = document.text(*grant, "subject_name");
    if (name == subject) return *grant;
    others += (others.empty() ? "" : "; ") + name;
  }
  document.refuse("grants nothing to the certificate's subject " +
                  escaped(subject, kShownOfMessage) +
                  " (the order of its parts matters); it names " +
                  (others.empty() ? "no subject" : escaped(others, kShownOfMessage)));
}

Permissions::Rule publish_rule(const Element& rule) {
  Permissions::Rule result;
  result.allows = std::string_view(rule.Name()) == "allow_rule";
  for (const Element* publish = rule.FirstChildElement("publish"); publish != nullptr;
       publish = publish->NextSiblingElement("publish")) {
    const Element* const topics = publish->FirstChildElement("topics");
    for (const Element* topic = topics == nullptr ? nullptr : topics->FirstChildElement("topic");
         topic != nullptr; topic = topic->NextSiblingElement("topic")) {
      result.topics.emplace_back(topic->GetText() == nullptr ? "" : topic->GetText());
    }
  }
  return result;
}

Permissions read_permissions(const Document& document, const Element& grant, std::uint32_t domain) {
  std::vector<Permissions::Rule> rules;
  bool by_default = false;
  bool is_named = false;
  for (const Element* entry = grant.FirstChildElement(); entry != nullptr;
       entry = entry->NextSiblingElement()) {
    const std::string_view name = entry->Name();
    if ((name == "allow_rule" || name == "deny_rule") && document.holds(*entry, domain)) {
      rules.push_back(publish_rule(*entry));
      is_named = is_named || name == "allow_rule";
    } else if (name == "default") {
      by_default = entry->GetText() != nullptr && std::string_view(entry->GetText()) == "ALLOW";
    }
  }
  if (!is_named && !by_default) {
    document.refuse("grants nothing in domain " + std::to_string(domain));
  }
  return {std::move(rules), by_default};
}

}  // namespace

bool Permissions::may_publish(const std::string& topic) const {
  for (const Rule& rule : rules_) {
    const bool names_it = std::ranges::any_of(rule.topics, [&](const auto& name) {
      return matches(name, topic);
    });
    if (names_it) return rule.allows;
  }
  return by_default_;
}

Permissions check_security(const std::filesystem::path& directory, std::uint32_t domain) {
  const std::string subject =
      check_identity(directory / SecurityFile::kIdentityCa, directory / SecurityFile::kCertificate,
                     directory / SecurityFile::kPrivateKey);
  const auto ca = directory / SecurityFile::kPermissionsCa;
  check_governance(Document(ca, directory / SecurityFile::kGovernance), domain);
  const Document permissions(ca, directory / SecurityFile::kPermissions);
  const Element& grant = grant_of(permissions, subject);
  check_validity(permissions, grant);
  return read_permissions(permissions, grant, domain);
}

}  // namespace vdrive::wire
