// SPDX-License-Identifier: Apache-2.0
#include "io/core/xml_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kUsualTag = 256;
constexpr std::int64_t kLongestTag = std::int64_t{1} << 16;

bool is_xml_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

void skip_blanks(std::string_view& text) {
  while (!text.empty() && is_xml_blank(text.front())) text.remove_prefix(1);
}

// Name and attributes from the text between '<' and '>'. What is no attribute ends the list: the
// real parser will complain.
XmlTag parse_tag(std::string_view text) {
  XmlTag tag;
  if (text.ends_with('/')) {
    tag.is_empty_element = true;
    text.remove_suffix(1);
  }
  std::size_t end = 0;
  while (end < text.size() && !is_xml_blank(text[end])) ++end;
  tag.name = text.substr(0, end);
  text.remove_prefix(end);
  while (true) {
    skip_blanks(text);
    const auto equals = text.find('=');
    if (equals == std::string_view::npos) return tag;
    std::string_view key = text.substr(0, equals);
    while (!key.empty() && is_xml_blank(key.back())) key.remove_suffix(1);
    text.remove_prefix(equals + 1);
    skip_blanks(text);
    if (text.empty() || (text.front() != '"' && text.front() != '\'')) return tag;
    const auto close = text.find(text.front(), 1);
    if (close == std::string_view::npos) return tag;
    tag.attributes.emplace(key, text.substr(1, close - 1));
    text.remove_prefix(close + 1);
  }
}

}  // namespace

std::string XmlTag::attribute(const std::string& key, const std::string& otherwise) const {
  const auto found = attributes.find(key);
  return found == attributes.end() ? otherwise : found->second;
}

std::int64_t XmlTagReader::find(char c, std::int64_t from) {
  while (from < source_.size()) {
    const bool is_inside =
        from >= window_begin_ && from < window_begin_ + static_cast<std::int64_t>(window_.size());
    if (!is_inside) {
      window_ = source_.text(from, kTextWindow);
      window_begin_ = from;
    }
    const auto found = window_.find(c, static_cast<std::size_t>(from - window_begin_));
    if (found != std::string::npos) return window_begin_ + static_cast<std::int64_t>(found);
    from = window_begin_ + static_cast<std::int64_t>(window_.size());
  }
  return -1;
}

// The tag's text from '<' to '>', both included; a '>' within quotes does not end it.
std::string XmlTagReader::tag_text(std::int64_t begin) {
  // A short piece first: files of many small tags would be copied over and over.
  for (const std::int64_t size : {kUsualTag, kLongestTag}) {
    const std::string text = source_.text(begin, size);
    char quote = '\0';
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (quote == '\0' && c == '>') return text.substr(0, i + 1);
      if (quote == '\0' && (c == '"' || c == '\'')) {
        quote = c;
      } else if (c == quote) {
        quote = '\0';
      }
    }
  }
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: the tag at byte {} does not end", source_.name(), begin));
}

std::optional<XmlTag> XmlTagReader::next() {
  while (true) {
    const std::int64_t begin = find('<', position_);
    if (begin < 0) return std::nullopt;
    const std::string start = source_.text(begin, 4);
    if (start == "<!--") {
      // A comment ends at "-->".
      std::int64_t close = begin + 3;
      do {
        close = find('>', close + 1);
        if (close < 0) return std::nullopt;
      } while (close < begin + 6 || source_.text(close - 2, 3) != "-->");
      position_ = close + 1;
      continue;
    }
    // Entities could be declared there that grow without end where they are used.
    if (start.starts_with("<!")) {
      throw Error(
          ErrorCode::kUnsupported,
          fmt::format("{}: the declaration at byte {} is not read: expected tags and comments",
                      source_.name(), begin));
    }
    const std::string text = tag_text(begin);
    position_ = begin + static_cast<std::int64_t>(text.size());
    if (start.starts_with("<?")) continue;
    XmlTag tag = parse_tag(std::string_view(text).substr(1, text.size() - 2));
    tag.begin = begin;
    tag.end = position_;
    return tag;
  }
}

std::optional<std::string> without_entities(std::string_view text) {
  static constexpr std::pair<std::string_view, char> kEntities[] = {
      {"&quot;", '"'}, {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&apos;", '\''}};
  std::string result;
  while (!text.empty()) {
    if (text.front() != '&') {
      result += text.front();
      text.remove_prefix(1);
      continue;
    }
    const auto* const known =
        std::find_if(std::begin(kEntities), std::end(kEntities),
                     [&](const auto& entity) { return text.starts_with(entity.first); });
    if (known == std::end(kEntities)) return std::nullopt;
    result += known->second;
    text.remove_prefix(known->first.size());
  }
  return result;
}

}  // namespace ovoid::io
