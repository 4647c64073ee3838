// SPDX-License-Identifier: Apache-2.0
#include "io/xdmf/xdmf_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "io/core/numbers.h"
#include "io/core/text_scanner.h"
#include "io/core/xml_tags.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kLongestPath = 4096;

// What a step of a path asks of an element.
struct XdmfTest {
  std::vector<std::string> names;  // one of these; none: any
  std::optional<std::pair<std::string, std::string>> attribute;
  std::optional<std::size_t> number;  // among those of its parent that pass the tests before it
};

struct XdmfStep {
  bool is_any_depth = false;  // "//"
  std::vector<XdmfTest> tests;
};

std::string_view without_prefix(std::string_view name) {
  const auto colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// "[1]", "[@Name='a']", "[self::Topology or self::Geometry]"
std::optional<XdmfTest> parse_predicate(std::string_view text) {
  XdmfTest test;
  text = trimmed(text);
  if (const auto number = parse_integer(text)) {
    if (*number < 1) return std::nullopt;
    test.number = static_cast<std::size_t>(*number - 1);
    return test;
  }
  if (text.starts_with('@')) {
    const auto equals = text.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    const std::string_view value = trimmed(text.substr(equals + 1));
    if (value.size() < 2 || (value.front() != '"' && value.front() != '\'') ||
        value.back() != value.front())
      return std::nullopt;
    test.attribute.emplace(trimmed(text.substr(1, equals - 1)), value.substr(1, value.size() - 2));
    return test;
  }
  for (const std::string_view word : words(text)) {
    if (word == "or") continue;
    if (!word.starts_with("self::")) return std::nullopt;
    test.names.emplace_back(word.substr(6));
  }
  return test.names.empty() ? std::nullopt : std::optional(std::move(test));
}

// The step at the front of `text`, which is taken off.
std::optional<XdmfStep> take_step(std::string_view& text) {
  XdmfStep step;
  if (text.starts_with('/')) text.remove_prefix(1);
  if (text.starts_with('/')) {
    step.is_any_depth = true;
    text.remove_prefix(1);
  }
  const std::string_view name = trimmed(text.substr(0, text.find_first_of("/[")));
  if (name.empty()) return std::nullopt;
  text.remove_prefix(std::min(text.size(), text.find_first_of("/[")));
  XdmfTest by_name;
  if (name != "*") by_name.names.emplace_back(without_prefix(name));
  step.tests.push_back(std::move(by_name));
  while (text.starts_with('[')) {
    // A quoted name may have brackets.
    char quote = '\0';
    std::size_t end = 1;
    for (; end < text.size() && (quote != '\0' || text[end] != ']'); ++end) {
      if (quote == '\0' && (text[end] == '"' || text[end] == '\''))
        quote = text[end];
      else if (text[end] == quote)
        quote = '\0';
    }
    if (end == text.size()) return std::nullopt;
    auto test = parse_predicate(text.substr(1, end - 1));
    if (!test) return std::nullopt;
    step.tests.push_back(std::move(*test));
    text.remove_prefix(end + 1);
  }
  return step;
}

bool passes(const XdmfElement& element, const XdmfTest& test) {
  if (test.attribute) {
    const auto found = element.attributes.find(test.attribute->first);
    return found != element.attributes.end() && found->second == test.attribute->second;
  }
  return test.names.empty() ||
         std::find(test.names.begin(), test.names.end(), element.name) != test.names.end();
}

}  // namespace

XdmfTree::XdmfTree(const ByteSource& source) : source_(source) {
  XmlTagReader reader(source, XmlTagReader::Doctype::kPassed);
  std::vector<std::size_t> open;
  const auto broken = [&](const std::string& what) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source.name(), what));
  };
  while (const auto tag = reader.next()) {
    if (!open.empty() && elements_[open.back()].text_end < 0)
      elements_[open.back()].text_end = tag->begin;
    if (tag->name.starts_with('/')) {
      const std::string_view name = without_prefix(std::string_view(tag->name).substr(1));
      if (open.empty() || elements_[open.back()].name != name)
        broken(fmt::format("the tag at byte {} ends what has not begun", tag->begin));
      open.pop_back();
      continue;
    }
    if (open.empty() && !elements_.empty()) broken("has several roots");
    if (elements_.size() == kMaxElements || open.size() == kMaxDepth) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: has more than {} elements, or {} within each other",
                              source.name(), kMaxElements, kMaxDepth));
    }
    XdmfElement element;
    element.name = without_prefix(tag->name);
    for (const auto& [key, value] : tag->attributes) {
      auto plain = without_entities(value);
      if (!plain) broken(fmt::format("the tag at byte {} has an unknown entity", tag->begin));
      element.attributes.emplace(without_prefix(key), std::move(*plain));
    }
    element.text_begin = tag->end;
    element.text_end = tag->is_empty_element ? tag->end : -1;
    const std::size_t number = elements_.size();
    if (!open.empty()) {
      element.parent = open.back();
      elements_[open.back()].children.push_back(number);
    }
    elements_.push_back(std::move(element));
    if (!tag->is_empty_element) open.push_back(number);
  }
  if (!open.empty()) broken(fmt::format("ends within its element {}", elements_[open.back()].name));
  if (elements_.empty() || elements_[0].name != "Xdmf") broken("has no element Xdmf");
}

void XdmfTree::fail(std::size_t element, const std::string& what) const {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: {}: {}", source_.name(), where(element), what));
}

void XdmfTree::refuse(std::size_t element, const std::string& what) const {
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: {}: {}", source_.name(), where(element), what));
}

std::string XdmfTree::where(std::size_t element) const {
  std::string text;
  for (std::size_t at = element; at != XdmfElement::kNone; at = elements_[at].parent) {
    const XdmfElement& one = elements_[at];
    const auto name = one.attributes.find("Name");
    if (name == one.attributes.end() && at != element) continue;
    const std::string here = name == one.attributes.end()
                                 ? one.name
                                 : fmt::format("{} '{}'", one.name, name->second.substr(0, 80));
    text = text.empty() ? here : fmt::format("{}, {}", here, text);
  }
  return text;
}

std::string XdmfTree::attribute(std::size_t element,
                                std::initializer_list<const char*> names) const {
  for (const char* const name : names) {
    const auto found = elements_[element].attributes.find(name);
    if (found != elements_[element].attributes.end()) return std::string(trimmed(found->second));
  }
  return {};
}

std::string XdmfTree::text(std::size_t element, std::int64_t most) const {
  const XdmfElement& one = elements_[element];
  const std::int64_t size = one.text_end - one.text_begin;
  if (size > most) fail(element, fmt::format("has {} bytes of text, more than {}", size, most));
  const std::string text = source_.text(one.text_begin, size);
  auto plain = without_entities(trimmed(text));
  if (!plain) fail(element, "has an unknown entity");
  return *plain;
}

std::vector<std::size_t> XdmfTree::found(std::size_t from, const std::string& path) const {
  std::string_view rest = trimmed(path);
  if (path.size() > static_cast<std::size_t>(kLongestPath)) fail(from, "has an endless path");
  // Above the root, which is none of its elements.
  std::vector<std::size_t> here{rest.starts_with('/') ? XdmfElement::kNone : from};
  while (!rest.empty()) {
    const auto step = take_step(rest);
    if (!step) {
      refuse(from, fmt::format("the path '{}' is not understood: expected steps like /Domain, "
                               "//Grid[@Name='a'] or Grid[1]",
                               path));
    }
    // Each parent's own list, since numbers count in it; those of "//" have all parents.
    std::vector<std::size_t> parents = here;
    if (step->is_any_depth) {
      parents.clear();
      const bool is_whole = here == std::vector{XdmfElement::kNone};
      if (!is_whole) refuse(from, fmt::format("the path '{}' has // behind its begin", path));
      parents.push_back(XdmfElement::kNone);
      for (std::size_t i = 0; i < elements_.size(); ++i)
        if (!elements_[i].children.empty()) parents.push_back(i);
    }
    here.clear();
    for (const std::size_t parent : parents) {
      std::vector<std::size_t> passing =
          parent == XdmfElement::kNone ? std::vector<std::size_t>{0} : elements_[parent].children;
      for (const XdmfTest& test : step->tests) {
        if (!test.number) {
          std::erase_if(passing, [&](std::size_t i) { return !passes(elements_[i], test); });
        } else if (*test.number < passing.size()) {
          passing = {passing[*test.number]};
        } else {
          passing.clear();
        }
      }
      here.insert(here.end(), passing.begin(), passing.end());
    }
  }
  return here;
}

std::vector<std::size_t> XdmfTree::included(std::size_t include) const {
  const std::string href = attribute(include, {"href"});
  if (!href.empty()) {
    refuse(include,
           fmt::format("includes '{}': expected what is in the file itself", href.substr(0, 80)));
  }
  std::string path = attribute(include, {"xpointer"});
  constexpr std::string_view kHead = "xpointer(";
  if (!path.starts_with(kHead) || !path.ends_with(')'))
    refuse(include, "has no xpointer(...) to follow");
  path = path.substr(kHead.size(), path.size() - kHead.size() - 1);
  std::vector<std::size_t> elements = found(include, path);
  if (elements.empty()) fail(include, fmt::format("'{}' is not in the file", path));
  return elements;
}

std::size_t XdmfTree::followed(std::size_t element) const {
  const std::size_t begin = element;
  constexpr int kMostReferences = 16;
  for (int i = 0; i < kMostReferences; ++i) {
    const std::string reference = attribute(element, {"Reference"});
    if (reference.empty()) return element;
    const std::string path = reference == "XML" ? text(element, kLongestPath) : reference;
    const std::vector<std::size_t> elements = found(element, path);
    if (elements.empty() || elements_[elements[0]].name != elements_[begin].name) {
      fail(begin, fmt::format("refers to '{}': there is no such {}", path.substr(0, 200),
                              elements_[begin].name));
    }
    element = elements[0];
  }
  fail(begin, "refers to itself");
}

std::vector<std::size_t> XdmfTree::children(std::size_t element, std::string_view name) const {
  std::vector<std::size_t> result;
  for (const std::size_t child : elements_[element].children) {
    if (elements_[child].name == name) {
      result.push_back(followed(child));
    } else if (elements_[child].name == "include") {
      for (const std::size_t other : included(child))
        if (elements_[other].name == name) result.push_back(followed(other));
    }
  }
  return result;
}

}  // namespace ovoid::io
