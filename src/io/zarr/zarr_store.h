// SPDX-License-Identifier: Apache-2.0
// Where a Zarr hierarchy lies: files of a folder, or entries of a zip file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

// Keys are paths from the root, "0/.zarray"; "" is the root. Immutable; many threads call it.
class ZarrStore {
 public:
  ZarrStore() = default;
  virtual ~ZarrStore() = default;
  ZarrStore(const ZarrStore&) = delete;
  ZarrStore& operator=(const ZarrStore&) = delete;

  // What a key is called in messages.
  virtual std::string name_of(const std::string& key) const = 0;
  // The value of a key; null if it is not there. Throws what opening throws.
  virtual std::unique_ptr<ByteSource> find(const std::string& key) const = 0;
  // Names of the folders right below a key, sorted; none if they cannot be listed.
  virtual std::vector<std::string> folders_in(const std::string& key) const = 0;
};

// `folder`: path of the root. `open` is copied.
std::shared_ptr<const ZarrStore> open_zarr_folder(const std::string& folder, const Opener& open);

// A zip file's entries, below the folder of the outermost that describes an array or a group. The
// file is opened again, by `open`. Throws Error(kFileFormat).
std::shared_ptr<const ZarrStore> open_zarr_zip(const ByteSource& source, const Opener& open);

// Whether a zip file has such entries. False for what is damaged.
bool is_zarr_zip(const ByteSource& source);

// "a/b" from "a" and "b", "b" from "" and "b".
std::string zarr_key(const std::string& group, const std::string& name);

// What describes an array or a group: ".zarray", ".zgroup", and version 3's "zarr.json".
bool is_zarr_description(const std::string& file_name);

}  // namespace ovoid::io
