// SPDX-License-Identifier: Apache-2.0
// The elements of an XDMF file as a tree. Built on XmlTagReader and not on a parser: text, which
// may be gigabytes of numbers, stays in the file; and nothing that such a file does not need
// (entities, namespaces, other documents) is there to be attacked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

struct XdmfElement {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::string name;                               // without a prefix: "include" for "xi:include"
  std::map<std::string, std::string> attributes;  // without entities
  std::size_t parent = kNone;
  std::vector<std::size_t> children;
  std::int64_t text_begin = 0, text_end = 0;  // up to its first child, or its end
};

// Elements are known by their numbers in the file. All members throw Error that names the file:
// kFileFormat for what is wrong, kUnsupported for what is not read.
class XdmfTree {
 public:
  static constexpr std::size_t kMaxElements = 2'000'000;
  static constexpr std::size_t kMaxDepth = 64;

  // `source` must outlive the tree. Throws unless the elements are one within the other and the
  // first is Xdmf.
  explicit XdmfTree(const ByteSource& source);

  const ByteSource& source() const noexcept { return source_; }
  const std::vector<XdmfElement>& elements() const noexcept { return elements_; }
  const XdmfElement& operator[](std::size_t element) const noexcept { return elements_[element]; }

  // The elements below that are called so, with what `xi:include` puts among them, references
  // followed.
  std::vector<std::size_t> children(std::size_t element, std::string_view name) const;

  // The value of the first of these attributes that is there; "" if none is.
  std::string attribute(std::size_t element, std::initializer_list<const char*> names) const;

  // The element's text, without blanks around it, of at most `most` bytes.
  std::string text(std::size_t element, std::int64_t most) const;

  // "Grid 'a', Attribute 'p'": where an element is, for messages.
  std::string where(std::size_t element) const;

  [[noreturn]] void fail(std::size_t element, const std::string& what) const;
  [[noreturn]] void refuse(std::size_t element, const std::string& what) const;

 private:
  std::vector<std::size_t> found(std::size_t from, const std::string& path) const;
  std::vector<std::size_t> included(std::size_t include) const;
  std::size_t followed(std::size_t element) const;

  const ByteSource& source_;
  std::vector<XdmfElement> elements_;
};

}  // namespace ovoid::io
