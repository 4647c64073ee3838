// SPDX-License-Identifier: Apache-2.0
#include "io/xdmf/xdmf_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "io/core/numbers.h"
#include "io/core/text_scanner.h"
#include "io/core/xml_entities.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kLongestPath = 4096;
constexpr std::size_t kMostFiles = 10'000;
constexpr std::int64_t kMostLooks = 300'000'000;  // some seconds
constexpr std::int64_t kLooksOfPath = 1000;       // what following any path costs

// Does a predicate look at its element alone? "1", "last()", "@Name='a' and @b='c'",
// "self::Topology or self::Geometry".
bool is_local_predicate(std::string_view text) {
  std::string plain;  // without what is quoted
  char quote = '\0';
  for (const char c : text) {
    if (quote == '\0' && (c == '"' || c == '\''))
      quote = c;
    else if (c == quote)
      quote = '\0';
    else if (quote == '\0')
      plain += c;
  }
  const auto replace = [&](std::string_view what, std::string_view by) {
    for (auto at = plain.find(what); at != std::string::npos; at = plain.find(what))
      plain.replace(at, what.size(), by);
  };
  replace("last()", "1");
  replace("position()", "1");
  replace("self::", "@");
  replace("=", " ");
  const std::vector<std::string_view> all = words(plain);
  return quote == '\0' && std::all_of(all.begin(), all.end(), [](std::string_view word) {
           return word == "or" || word == "and" || parse_integer(word) ||
                  (word.front() == '@' && word.find_first_of("/()[]|*:") == std::string_view::npos);
         });
}

// XPath can be made to work for years: paths are refused whose cost is not about one look at each
// element. These are steps downwards, "//" at the begin alone, with predicates as above.
bool is_cheap_path(std::string_view path) {
  if (path.starts_with("//")) path.remove_prefix(2);
  std::string steps;
  while (!path.empty()) {
    const auto open = path.find('[');
    steps += path.substr(0, open);
    if (open == std::string_view::npos) break;
    // A quoted name may have brackets.
    char quote = '\0';
    std::size_t end = open + 1;
    for (; end < path.size() && (quote != '\0' || path[end] != ']'); ++end) {
      if (quote == '\0' && (path[end] == '"' || path[end] == '\''))
        quote = path[end];
      else if (path[end] == quote)
        quote = '\0';
    }
    if (end == path.size() || !is_local_predicate(path.substr(open + 1, end - open - 1)))
      return false;
    path.remove_prefix(end + 1);
  }
  return steps.find("//") == std::string::npos && steps.find("..") == std::string::npos &&
         steps.find("::") == std::string::npos &&
         steps.find_first_of("()|\"'=<>+,$") == std::string::npos;
}

// The path of "element(/1/2/1)", whose numbers count elements; "" for another form.
std::string path_of_numbers(std::string_view text) {
  std::string path;
  for (; !text.empty(); text.remove_prefix(std::min(text.size(), text.find('/', 1)))) {
    const auto number = parse_integer(text.substr(1, text.find('/', 1) - 1));
    if (text.front() != '/' || !number || *number < 1) return {};
    path += fmt::format("/*[{}]", *number);
  }
  return path;
}

void collect_elements(XdmfNode root, std::vector<XdmfNode>& all) {
  struct Collector : pugi::xml_tree_walker {
    explicit Collector(std::vector<XdmfNode>& into) : all(into) {}
    bool for_each(XdmfNode& node) override {
      if (node.type() == pugi::node_element) all.push_back(node);
      return true;
    }
    std::vector<XdmfNode>& all;
  } collector(all);
  if (root) all.push_back(root);
  root.traverse(collector);
}

}  // namespace

XdmfTree::XdmfTree(const ByteSource& source, const Opener& open)
    : source_(source), open_(open), document_(source) {
  if (xml_name(root()) != "Xdmf")
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no element Xdmf", source.name()));
  std::vector<XdmfNode> own;
  collect_elements(root(), own);
  count(own);
}

void XdmfTree::count(const std::vector<XdmfNode>& elements) const {
  num_elements_ += static_cast<std::int64_t>(elements.size());
  for (const XdmfNode element : elements) {
    const auto children = element.children();
    most_children_ =
        std::max<std::int64_t>(most_children_, std::distance(children.begin(), children.end()));
  }
}

void XdmfTree::look(XdmfNode element, std::int64_t count) const {
  num_looks_ += count;
  if (num_looks_ > kMostLooks)
    refuse(element, "refers to others, and these to others, more often than can be followed");
}

std::vector<XdmfNode> XdmfTree::elements() const {
  std::vector<XdmfNode> all;
  collect_elements(root(), all);
  std::set<XdmfNode> roots{root()};
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string name =
        xml_name(all[i]) == "include" ? attribute(all[i], {"href"}) : std::string();
    if (name.empty()) continue;
    const XdmfNode other = root_of_file(all[i], name);
    if (roots.insert(other).second) collect_elements(other, all);
  }
  return all;
}

std::vector<std::string> XdmfTree::included_files() const {
  std::vector<std::string> files;
  for (const auto& [path, document] : others_) files.push_back(path);
  return files;
}

XdmfNode XdmfTree::root_of_file(XdmfNode include, const std::string& name) const {
  const std::string path = path_beside(source_.name(), name);
  const auto known = others_.find(path);
  if (known != others_.end()) return known->second->root();
  if (others_.size() == kMostFiles)
    refuse(include, fmt::format("includes one of more than {} files", kMostFiles));
  const std::unique_ptr<ByteSource> source = open_(path);
  auto document = std::make_unique<XmlDocument>(*source);
  std::vector<XdmfNode> own;
  collect_elements(document->root(), own);
  count(own);
  if (num_elements_ > static_cast<std::int64_t>(XmlDocument::kMaxElements))
    refuse(include, fmt::format("includes files of more than {} elements in all",
                                XmlDocument::kMaxElements));
  return others_.emplace(path, std::move(document)).first->second->root();
}

void XdmfTree::fail(XdmfNode element, const std::string& what) const {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: {}: {}", source_.name(), where(element), in_one_line(what)));
}

void XdmfTree::refuse(XdmfNode element, const std::string& what) const {
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: {}: {}", source_.name(), where(element), in_one_line(what)));
}

std::string XdmfTree::where(XdmfNode element) const {
  std::string text;
  for (XdmfNode at = element; at.type() == pugi::node_element; at = at.parent()) {
    const pugi::xml_attribute name = at.attribute("Name");
    if (!name && at != element) continue;
    const std::string_view kind = xml_name(at).substr(0, 40);
    const std::string here =
        name ? fmt::format("{} '{}'", kind, std::string_view(name.value()).substr(0, 80))
             : std::string(kind);
    text = text.empty() ? here : fmt::format("{}, {}", here, text);
  }
  return in_one_line(text);
}

std::string XdmfTree::attribute(XdmfNode element, std::initializer_list<const char*> names) const {
  for (const char* const name : names)
    if (const pugi::xml_attribute found = element.attribute(name))
      return std::string(trimmed(found.value()));
  return {};
}

std::string XdmfTree::text(XdmfNode element, std::int64_t most) const {
  const std::string text = xml_text(element);
  const auto size = static_cast<std::int64_t>(text.size());
  if (size > most) fail(element, fmt::format("has {} bytes of text, more than {}", size, most));
  return std::string(trimmed(text));
}

std::vector<XdmfNode> XdmfTree::found(XdmfNode from, const std::string& path) const {
  if (path.size() > static_cast<std::size_t>(kLongestPath)) fail(from, "has an endless path");
  const std::string shown = path.substr(0, 200);
  const std::string plain(trimmed(path));
  if (!is_cheap_path(plain)) {
    refuse(from, fmt::format("the path '{}' is not read: expected steps like /Domain, "
                             "//Grid[@Name='a'] or Grid[1]",
                             shown));
  }
  look(from, kLooksOfPath + (plain.starts_with("//") ? num_elements_ : most_children_));
  std::vector<XdmfNode> nodes;
  try {
    for (const pugi::xpath_node& node : from.select_nodes(plain.c_str()))
      if (node.node().type() == pugi::node_element) nodes.push_back(node.node());
  } catch (const pugi::xpath_exception& problem) {
    refuse(from, fmt::format("the path '{}' is not understood: {}", shown, problem.what()));
  }
  return nodes;
}

std::vector<XdmfNode> XdmfTree::included(XdmfNode include) const {
  const std::string file = attribute(include, {"href"});
  const XdmfNode from = file.empty() ? include : root_of_file(include, file);
  const std::string pointer = attribute(include, {"xpointer"});
  if (pointer.empty() && !file.empty()) return {from};
  const auto open = pointer.find('(');
  const std::string scheme = pointer.substr(0, open);
  if (open == std::string::npos || !pointer.ends_with(')') ||
      (scheme != "xpointer" && scheme != "element"))
    refuse(include, "has no xpointer(...) or element(...) to follow");
  std::string path = pointer.substr(open + 1, pointer.size() - open - 2);
  if (scheme == "element") path = path_of_numbers(path);
  if (path.empty()) refuse(include, fmt::format("'{}' is not understood", pointer.substr(0, 80)));
  std::vector<XdmfNode> elements = found(from, path);
  if (elements.empty())
    fail(include, fmt::format("'{}' is not in {}", pointer.substr(0, 200),
                              file.empty() ? "the file" : file.substr(0, 80)));
  return elements;
}

XdmfNode XdmfTree::followed(XdmfNode element) const {
  const XdmfNode begin = element;
  constexpr int kMostReferences = 16;
  for (int i = 0; i < kMostReferences; ++i) {
    const std::string reference = attribute(element, {"Reference"});
    if (reference.empty()) return element;
    const std::string path = reference == "XML" ? text(element, kLongestPath) : reference;
    const std::vector<XdmfNode> elements = found(element, path);
    if (elements.empty() || xml_name(elements[0]) != xml_name(begin)) {
      fail(begin, fmt::format("refers to '{}': there is no such {}", path.substr(0, 200),
                              xml_name(begin)));
    }
    element = elements[0];
  }
  fail(begin, "refers to itself");
}

std::vector<XdmfNode> XdmfTree::children(XdmfNode element, std::string_view name) const {
  std::vector<XdmfNode> result;
  for (const XdmfNode child : element.children()) {
    look(element, 1);
    if (xml_name(child) == name) {
      result.push_back(followed(child));
    } else if (xml_name(child) == "include") {
      for (const XdmfNode other : included(child))
        if (xml_name(other) == name) result.push_back(followed(other));
    }
  }
  return result;
}

}  // namespace ovoid::io
