// SPDX-License-Identifier: Apache-2.0
#include "io/core/xml_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "io/core/memory.h"
#include "io/core/xml_entities.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// The bytes of memory that pugixml takes for an element or text, and for an attribute.
constexpr std::int64_t kNodeSize = 64, kAttributeSize = 40;

[[noreturn]] void throw_limits(const ByteSource& source) {
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: has more than {} elements, or {} within each other", source.name(),
                          XmlDocument::kMaxElements, XmlDocument::kMaxDepth));
}

void check_size(const ByteSource& source, const std::string& text) {
  const std::int64_t num_tags = std::count(text.begin(), text.end(), '<');
  // Each element has two tags at most; others are comments and the like.
  if (num_tags > 2 * static_cast<std::int64_t>(XmlDocument::kMaxElements)) throw_limits(source);
  require_memory(source.name(),
                 2 * num_tags * kNodeSize +  // each with text behind it
                     std::count(text.begin(), text.end(), '=') * kAttributeSize);
}

// Stops where there are too many elements, or they are too deep.
struct LimitWalker : pugi::xml_tree_walker {
  bool for_each(pugi::xml_node& node) override {
    if (node.type() != pugi::node_element) return true;
    return ++num_elements <= XmlDocument::kMaxElements &&
           depth() < static_cast<int>(XmlDocument::kMaxDepth);
  }
  std::size_t num_elements = 0;
};

}  // namespace

XmlDocument::XmlDocument(const ByteSource& source) {
  require_memory(source.name(), source.size());
  text_ = with_own_entities(source.name(), source.text(0, source.size()));
  check_size(source, text_);
  const pugi::xml_parse_result result =
      document_.load_buffer_inplace(text_.data(), text_.size(), pugi::parse_default);
  if (result.status == pugi::status_out_of_memory)
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("{}: its elements do not fit into memory", source.name()));
  if (!result)
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: is no XML from byte {} on: {}", source.name(), result.offset,
                            result.description()));
  LimitWalker walker;
  if (!document_.traverse(walker)) throw_limits(source);
  const auto roots = document_.children();
  if (std::count_if(roots.begin(), roots.end(),
                    [](pugi::xml_node node) { return node.type() == pugi::node_element; }) > 1)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has several roots", source.name()));
}

std::string_view xml_name(pugi::xml_node element) {
  const std::string_view name = element.name();
  const auto colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

std::string xml_text(pugi::xml_node element) {
  std::string text;
  for (const pugi::xml_node child : element.children()) {
    if (child.type() == pugi::node_element) break;
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
      text += child.value();
  }
  return text;
}

}  // namespace ovoid::io
