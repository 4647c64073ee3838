// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/mesh_readers.h"

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "io/core/signatures.h"
#include "io/core/text_scanner.h"
#include "io/foreign/file_checks.h"
#include "ovoid/error.h"

namespace ovoid::io {
// The HDF5 files of an Enzo hierarchy lie beside it, whatever folder it names.
void check_enzo(const ByteSource& named) {
  const bool is_hierarchy = named.name().ends_with(".hierarchy");
  const std::string path = is_hierarchy ? named.name() : named.name() + ".hierarchy";
  const auto source = open_file(path);
  TextScanner text(*source, 0, source->size());
  std::string last;
  std::int64_t num_files = 0;
  while (auto line = text.line()) {
    const auto parts = words(*line);
    if (parts.size() != 3 || parts[0] != "BaryonFileName" || parts[1] != "=") continue;
    ++num_files;
    const std::string name(std::filesystem::path(parts[2]).filename().string());
    if (name == last) continue;
    last = name;
    const auto file = open_file(path_beside(path, name));
    if (!is_hdf5(file->text(0, 8))) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: is no HDF5 file, {} says it holds its grids", file->name(), path));
    }
    check_hdf5_size(*file);
  }
  if (num_files == 0) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has no BaryonFileName: expected an Enzo hierarchy", path));
  }
}

}  // namespace ovoid::io
