// SPDX-License-Identifier: Apache-2.0
// The elements of an XDMF file: what is in them, what they refer to, and where they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/xml_document.h"

namespace ovoid::io {

using XdmfNode = pugi::xml_node;

// All members throw Error that names the file: kFileFormat for what is wrong, kUnsupported for what
// is not read.
class XdmfTree {
 public:
  // Both must outlive the tree; `open` opens files that `xi:include` names. Throws as XmlDocument
  // does, and unless the root is Xdmf.
  XdmfTree(const ByteSource& source, const Opener& open);

  const ByteSource& source() const noexcept { return source_; }
  XdmfNode root() const { return document_.root(); }
  // All elements of the file, in its order, then those of the files that it includes.
  std::vector<XdmfNode> elements() const;
  // The files that are included by elements() or whatever was asked for.
  std::vector<std::string> included_files() const;

  // The elements below that are called so, with what `xi:include` puts among them, references
  // followed.
  std::vector<XdmfNode> children(XdmfNode element, std::string_view name) const;

  // The value of the first of these attributes that is there; "" if none is.
  std::string attribute(XdmfNode element, std::initializer_list<const char*> names) const;

  // The element's text, without blanks around it, of at most `most` bytes.
  std::string text(XdmfNode element, std::int64_t most) const;

  // "Grid 'a', Attribute 'p'": where an element is, for messages.
  std::string where(XdmfNode element) const;

  [[noreturn]] void fail(XdmfNode element, const std::string& what) const;
  [[noreturn]] void refuse(XdmfNode element, const std::string& what) const;

 private:
  std::vector<XdmfNode> found(XdmfNode from, const std::string& path) const;
  std::vector<XdmfNode> included(XdmfNode include) const;
  XdmfNode followed(XdmfNode element) const;
  XdmfNode root_of_file(XdmfNode include, const std::string& name) const;
  void count(const std::vector<XdmfNode>& elements) const;
  // Counts looks at elements: grids that hold themselves many times would never end.
  void look(XdmfNode element, std::int64_t count) const;

  const ByteSource& source_;
  const Opener& open_;
  XmlDocument document_;
  mutable std::map<std::string, std::unique_ptr<XmlDocument>> others_;  // by path
  mutable std::int64_t num_elements_ = 0, most_children_ = 0, num_looks_ = 0;
};

}  // namespace ovoid::io
