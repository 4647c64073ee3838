// SPDX-License-Identifier: Apache-2.0
// What every reader that goes through VTK needs. Only with VTK (OVOID_IO_VTK); sees its headers in
// the source file alone.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

// NOLINTBEGIN(cppcoreguidelines-virtual-class-destructor): VTK counts references
class vtkAlgorithm;
class vtkDataArray;
class vtkFieldData;
// NOLINTEND(cppcoreguidelines-virtual-class-destructor)

namespace ovoid::io {

// Runs a reader: its messages are collected, its progress is passed on, and the caller may stop it.
class VtkRun {
 public:
  VtkRun(const ByteSource& source, const ReadOptions& options)
      : source_(source), options_(options) {}

  // Throws Error(kFileFormat) with VTK's first error, kCancelled, kOutOfMemory. Warnings go to
  // `notes`.
  void operator()(vtkAlgorithm* reader, const std::function<void()>& action);

  std::vector<std::string> notes;

 private:
  void on_progress(vtkAlgorithm* reader);

  const ByteSource& source_;
  const ReadOptions& options_;
  bool was_stopped_ = false;
};

// The file for VTK's readers, some of which know no file without a folder.
std::string path_for_vtk(const ByteSource& source);

// The type of VTK's type number; empty for text, and for bits.
std::optional<ScalarType> scalar_type_of(int vtk_type);

// The array's memory, shared with it; copied if its layout is not the plain one.
Bytes share(vtkDataArray* array, std::int64_t num_bytes);

// One array of points or cells: its numbers, or a note that says why it has none for us.
struct VtkArray {
  std::string name;
  std::optional<DataArray> numbers;
  std::string note;
};

// All arrays of `fields`, which should have `num_expected` tuples; bits as uint8.
std::vector<VtkArray> numbers_of(const std::string& source, vtkFieldData* fields,
                                 std::int64_t num_expected, bool is_cell_data);

}  // namespace ovoid::io
