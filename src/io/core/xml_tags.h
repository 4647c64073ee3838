// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "io/core/byte_source.h"

namespace ovoid::io {

// One tag of an XML file.
struct XmlTag {
  std::string name;                               // "/name" for an end tag
  std::map<std::string, std::string> attributes;  // values as they stand, entities included
  bool is_empty_element = false;                  // <name ... />
  std::int64_t begin = 0;                         // offset of '<'
  std::int64_t end = 0;                           // offset behind '>'

  std::string attribute(const std::string& key, const std::string& otherwise = {}) const;
};

// Walks the tags of a file in order, without a tree and without keeping text: enough to look at a
// header before a real parser is let loose on it. Comments, processing instructions and text are
// passed over.
class XmlTagReader {
 public:
  explicit XmlTagReader(const ByteSource& source) : source_(source) {}

  // The next tag; empty at the end of the file. Throws Error: kFileFormat for a tag that does not
  // end or is longer than 64 KiB, kUnsupported for a declaration.
  std::optional<XmlTag> next();

 private:
  // Offset of the first `c` at or behind `from`, or -1. `limit` bytes are searched at most.
  std::int64_t find(char c, std::int64_t from);
  std::string tag_text(std::int64_t begin);

  const ByteSource& source_;
  std::int64_t position_ = 0;
  std::string window_;  // a piece of the file
  std::int64_t window_begin_ = 0;
};

// The value of an attribute, or text, without the five entities that XML itself knows. Nothing for
// any other entity.
std::optional<std::string> without_entities(std::string_view text);

}  // namespace ovoid::io
