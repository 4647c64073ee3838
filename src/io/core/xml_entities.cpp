// SPDX-License-Identifier: Apache-2.0
#include "io/core/xml_entities.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string_view>

#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kLongestEntityName = 256;
constexpr std::size_t kMostEntities = 10'000;
constexpr std::size_t kMostEntityText = std::size_t{1} << 24;
constexpr int kDeepestEntity = 16;

// Regions that hold no references: what they begin and end with.
struct PlainRegion {
  std::string_view begin, end;
};
constexpr std::array<PlainRegion, 3> kPlainRegions{
    {{"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}}};

// The length of the region that `text` begins with, all of it if it does not end; 0 for no region.
std::size_t plain_region(std::string_view text) {
  for (const PlainRegion& region : kPlainRegions) {
    if (!text.starts_with(region.begin)) continue;
    const auto end = text.find(region.end, region.begin.size());
    return end == std::string_view::npos ? text.size() : end + region.end.size();
  }
  return 0;
}

// The name at the front of `text`, as far as its letters go.
std::string_view entity_name_at(std::string_view text) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == ':' || c == '.' || c == '-' || static_cast<unsigned char>(c) >= 128;
  };
  const auto* const end = std::find_if_not(text.begin(), text.end(), is_letter);
  return text.substr(0, static_cast<std::size_t>(end - text.begin()));
}

bool is_of_xml(std::string_view name) {
  constexpr std::array<std::string_view, 5> kOfXml{"quot", "amp", "lt", "gt", "apos"};
  return std::find(kOfXml.begin(), kOfXml.end(), name) != kOfXml.end();
}

// What a DOCTYPE declares.
struct XmlEntity {
  std::string value;
  bool is_elsewhere = false;  // `value` names a file
};

class XmlEntities {
 public:
  XmlEntities(const std::string& file, std::string_view text) : file_(file) { declare(text); }

  std::string put_in(std::string_view text) {
    std::string out(text.substr(0, begin_));
    out.reserve(text.size());
    append(text.substr(begin_), out, 0, '\0');
    return out;
  }

 private:
  [[noreturn]] void refuse(std::string_view name, const std::string& what,
                           ErrorCode code = ErrorCode::kUnsupported) const {
    throw Error(code, fmt::format("{}: the entity '&{};' {}", file_,
                                  name.substr(0, kLongestEntityName), in_one_line(what)));
  }

  // Takes in the DOCTYPE, which stands before the first element.
  void declare(std::string_view text) {
    std::size_t at = 0;
    while (true) {
      at = text.find('<', at);
      if (at == std::string_view::npos) return;
      const std::size_t length = plain_region(text.substr(at));
      if (length == 0) break;
      at += length;
    }
    if (!text.substr(at).starts_with("<!DOCTYPE")) return;
    bool is_inside = false;  // of the brackets with declarations
    for (; at < text.size(); ++at) {
      const char c = text[at];
      if (c == '"' || c == '\'') {
        at = text.find(c, at + 1);
        if (at == std::string_view::npos) return;
      } else if (const std::size_t length = is_inside ? plain_region(text.substr(at)) : 0) {
        at += length - 1;
      } else if (is_inside && text.substr(at).starts_with("<!ENTITY")) {
        at = declare_one(text, at + 8) - 1;
      } else if (c == '[' || c == ']') {
        is_inside = c == '[';
      } else if (c == '>' && !is_inside) {
        begin_ = at + 1;
        return;
      }
    }
  }

  // One declaration, from behind "<!ENTITY" on; returns where it ends.
  std::size_t declare_one(std::string_view text, std::size_t at) {
    const auto skip = [&] {
      while (at < text.size() && is_blank(text[at])) ++at;
    };
    skip();
    const std::string_view name = entity_name_at(text.substr(at));
    at += name.size();
    skip();
    XmlEntity entity;
    const std::string_view keyword = entity_name_at(text.substr(at));
    entity.is_elsewhere = keyword == "SYSTEM" || keyword == "PUBLIC";
    at += keyword.size();
    // The last literal: behind PUBLIC a file's name is the second.
    while (at < text.size() && text[at] != '>') {
      if (text[at] == '"' || text[at] == '\'') {
        const auto end = text.find(text[at], at + 1);
        if (end == std::string_view::npos) return text.size();
        entity.value = text.substr(at + 1, end - at - 1);
        at = end;
      }
      ++at;
    }
    // One of a '%' is for declarations alone, and has no name here.
    if (name.empty()) return at;
    if (entities_.size() == kMostEntities)
      refuse(name, fmt::format("is one of more than {} that are declared", kMostEntities));
    entities_.try_emplace(std::string(name), std::move(entity));
    return at;
  }

  void count(std::string_view name, std::size_t size) {
    put_in_ += size + 1;
    if (put_in_ > kMostEntityText)
      refuse(name, fmt::format("would put in more than {} bytes or references", kMostEntityText));
  }

  // `quote`: of the attribute that the text is part of; what it says cannot end it.
  void append(std::string_view text, std::string& out, int depth, char quote) {
    bool is_tag = quote != '\0';
    const char outer_quote = quote;
    for (std::size_t at = 0; at < text.size(); ++at) {
      const char c = text[at];
      const bool is_markup = outer_quote == '\0' && quote == '\0';
      if (c == '&') {
        at += append_reference(text.substr(at), out, depth, quote) - 1;
      } else if (const std::size_t length =
                     is_markup && c == '<' ? plain_region(text.substr(at)) : 0) {
        out += text.substr(at, length);
        at += length - 1;
      } else if (outer_quote != '\0' && (c == '"' || c == '\'')) {
        out += c == '"' ? "&quot;" : "&apos;";
      } else {
        if (is_markup && (c == '<' || c == '>')) is_tag = c == '<';
        if (is_tag && outer_quote == '\0' && (c == '"' || c == '\'')) {
          if (quote == '\0')
            quote = c;
          else if (quote == c)
            quote = '\0';
        }
        out += c;
      }
    }
  }

  // What `text` begins with; returns how much of it that is. An '&' alone is left to the parser.
  std::size_t append_reference(std::string_view text, std::string& out, int depth, char quote) {
    const std::string_view name = entity_name_at(text.substr(1, kLongestEntityName + 1));
    const bool is_reference = !name.empty() && name.size() <= kLongestEntityName &&
                              text.size() > name.size() + 1 && text[name.size() + 1] == ';';
    if (!is_reference || is_of_xml(name)) {
      out += '&';
      return 1;
    }
    const auto known = entities_.find(name);
    if (known == entities_.end())
      refuse(name, "is not declared: expected a declaration in the file's DOCTYPE",
             ErrorCode::kFileFormat);
    if (known->second.is_elsewhere)
      refuse(name, fmt::format("stands for '{}', another file, which is not read",
                               known->second.value.substr(0, 80)));
    if (depth == kDeepestEntity) refuse(name, "is made of entities that are made of entities");
    count(name, known->second.value.size());
    append(known->second.value, out, depth + 1, quote);
    return name.size() + 2;
  }

  const std::string& file_;
  std::map<std::string, XmlEntity, std::less<>> entities_;
  std::size_t begin_ = 0;  // of what is behind the DOCTYPE
  std::size_t put_in_ = 0;
};

}  // namespace

std::string in_one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

std::string with_own_entities(const std::string& file, std::string text) {
  if (text.find('&') == std::string::npos) return text;
  return XmlEntities(file, text).put_in(text);
}

}  // namespace ovoid::io
