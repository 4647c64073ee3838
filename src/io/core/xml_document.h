// SPDX-License-Identifier: Apache-2.0
// An XML file as pugixml's tree, with limits. What a file may say in XML is all read: CDATA,
// comments, processing instructions, entities of its own.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <pugixml.hpp>

#include "io/core/byte_source.h"

namespace ovoid::io {

class XmlDocument {
 public:
  static constexpr std::size_t kMaxElements = 2'000'000;
  static constexpr std::size_t kMaxDepth = 64;

  // Reads the whole file. Throws Error that names it: kFileFormat unless the elements are one
  // within the other and there is one root, kUnsupported beyond the limits above and as
  // with_own_entities() says, kOutOfMemory.
  explicit XmlDocument(const ByteSource& source);

  pugi::xml_node root() const { return document_.document_element(); }

 private:
  std::string text_;  // the tree's names and values lie in it
  pugi::xml_document document_;
};

// "include" of "xi:include".
std::string_view xml_name(pugi::xml_node element);

// Text and CDATA of an element, as far as its first child element.
std::string xml_text(pugi::xml_node element);

}  // namespace ovoid::io
