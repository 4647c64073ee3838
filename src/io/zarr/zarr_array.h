// SPDX-License-Identifier: Apache-2.0
// What a Zarr array says of itself, in version 2 (.zarray and .zattrs) or 3 (zarr.json).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/core/chunked_array.h"
#include "io/core/json_file.h"
#include "io/zarr/zarr_store.h"

namespace ovoid::io {

// An array or a group, as far as its own description goes.
struct ZarrNode {
  std::string key;  // of its folder, "" for the root
  bool is_array = false;
  int version = 2;
  Json description;                     // .zarray or zarr.json; null of a group of version 2
  Json attributes;                      // an object
  std::string where, attributes_where;  // the files of both, for messages
};

// Nothing if there is neither. What of the attributes cannot be read is told in `notes`, which may
// be null. Throws Error(kFileFormat) for a description that is broken.
std::optional<ZarrNode> find_zarr_node(const ZarrStore& store, const std::string& key,
                                       std::vector<std::string>* notes = nullptr);

// The array with all but `axes`, which is empty, and channels; `name` is "values". Its samples are
// read from `store`, which it keeps. A chunk that is not there holds the fill value, or zeros.
// Throws Error: kFileFormat for what is broken, kUnsupported naming what is not read.
ChunkedArray zarr_array(const std::shared_ptr<const ZarrStore>& store, const ZarrNode& node);

// The names of the array's axes, as xarray and version 3 have them; empty if it has none.
std::vector<std::string> zarr_axis_names(const ZarrNode& node);

}  // namespace ovoid::io
