// SPDX-License-Identifier: Apache-2.0
// The numbers of XDMF's DataItems: inline, in raw files, in HDF5, and hyperslabs of these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "io/xdmf/xdmf_tree.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// An array that is somewhere, and read by its rows.
struct XdmfStored {
  std::vector<std::int64_t> dims;  // slowest first, 1 or more each
  ScalarType type = ScalarType::kFloat32;
  // Rows along the slowest axis from `first` on, as many as `out` takes, in native byte order.
  std::function<void(std::int64_t first, std::span<std::byte> out)> read;
};

// An array that was read.
struct XdmfNumbers {
  std::vector<std::int64_t> dims;
  ScalarType type = ScalarType::kFloat32;
  Bytes bytes;

  std::int64_t count() const noexcept {
    return static_cast<std::int64_t>(bytes.view.size() / size_of(type));
  }
  double number(std::int64_t index) const;
};

// Finds the dataset `path` in an HDF5 file; `where` is for messages. Throws Error.
using XdmfHdf5 = XdmfStored (*)(const std::string& where, const std::string& file,
                                const std::string& path, ReadProgress& progress);

// HDF5 is read in the reader's process, which says here how (foreign/hdf5_xdmf.h).
void set_xdmf_hdf5(XdmfHdf5 reader) noexcept;
bool has_xdmf_hdf5() noexcept;

// "file.h5:/path" as an item names it.
struct XdmfHdf5Name {
  std::string file;  // beside the XDMF
  std::string path;
};

// The names of the file or dataset that an item lies in.
bool is_xdmf_hdf5(const XdmfTree& tree, XdmfNode item);
bool is_xdmf_binary(const XdmfTree& tree, XdmfNode item);
XdmfHdf5Name xdmf_hdf5_name(const XdmfTree& tree, XdmfNode item);
std::string xdmf_binary_name(const XdmfTree& tree, XdmfNode item);

// Is the item made of others in a way that is not read? All functions are but JOIN($0, $1, ...).
bool is_xdmf_formula(const XdmfTree& tree, XdmfNode item);

// "2 3 4", of an element's attribute. Throws Error(kFileFormat) unless all are 1 or more and their
// product is at most kMaxNumBytes / 8; kUnsupported for more than 8 of them.
std::vector<std::int64_t> xdmf_dims(const XdmfTree& tree, XdmfNode element,
                                    const std::string& text);

class XdmfItems {
 public:
  // All must outlive it.
  XdmfItems(const XdmfTree& tree, const Opener& open, ReadProgress& progress)
      : tree_(tree), open_(open), progress_(progress) {}

  // The numbers of the DataItem. Sizes are compared with what is there before memory is taken.
  // Throws Error naming it.
  XdmfNumbers read(XdmfNode item) const { return read_at(item, 0); }

 private:
  XdmfStored stored(XdmfNode item) const;
  XdmfStored stored_text(XdmfNode item, ScalarType type) const;
  XdmfStored stored_binary(XdmfNode item, ScalarType type) const;
  XdmfStored stored_hdf5(XdmfNode item) const;
  // `depth`: of items within items.
  XdmfNumbers read_at(XdmfNode item, int depth) const;
  XdmfNumbers read_slab(XdmfNode item, int depth) const;
  XdmfNumbers read_join(XdmfNode item, int depth) const;
  XdmfNumbers read_rows(XdmfNode item, const XdmfStored& stored, std::int64_t first,
                        std::int64_t count) const;

  const XdmfTree& tree_;
  const Opener& open_;
  ReadProgress& progress_;
};

}  // namespace ovoid::io
