// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/io.h"
#include "ovoid/lattice.h"
#include "ovoid/lattice_boxes.h"
#include "ovoid/lattice_levels.h"
#include "ovoid/relevant.h"

namespace OVOID_API ovoid {

// One array of a lattice file: what DataArray says of its samples, without them.
struct LatticeFileArray {
  std::string name = "values";
  ScalarType type = ScalarType::kFloat32;
  int num_components = 1;    // >= 1
  std::string unit;          // empty: not known
  double value_scale = 1.0;  // value = stored number * scale + offset; finite, scale not 0
  double value_offset = 0.0;
};

// What was written so far, of all steps and arrays together.
struct LatticeFileCounts {
  std::int64_t num_samples = 0;
  std::int64_t num_relevant = 0;  // that were kept: all, of runs some; or kernels, or boxes
  std::int64_t num_runs = 0;
  std::int64_t dense_bytes = 0;  // of all samples, as they are in memory
  std::int64_t run_bytes = 0;    // of the runs and their samples, as they are in memory
};

// What stands for the samples of a step: themselves, or runs of them, by write_step(); what
// LatticeLevels or LatticeBoxes say, by write_levels() or write_boxes().
enum class LatticeContent { kSamples, kLevels, kBoxes };

// What a lattice file says beside its samples.
struct LatticeFileHeader {
  // Of every step; kStaggered: Cartesian, of the even ones, while the odd ones have as many samples
  // and lie half of each axis vector further.
  LatticeGeometry lattice;
  SeriesKind series = SeriesKind::kSteps;
  Space space = Space::kNone;
  std::vector<LatticeFileArray> arrays;  // at least one
  std::vector<double> times;  // of all steps, finite, rising in equal distances if staggered;
                              // empty: not known
  std::string time_unit;      // empty: not known
  std::optional<RelevantSamples> relevant;  // keep these alone, as runs: arrays of one component
  // Levels and boxes: a Cartesian lattice, not staggered, arrays of one component that are float32
  // or, where LatticeLevels::whole, LatticeBoxes::whole, integers of 1 or 2 bytes.
  LatticeContent content = LatticeContent::kSamples;
};

// The header of a file of `dataset` alone: its lattice, arrays and, of the times, that of its step.
// Arrays per cell lie on the lattice of the cells' centres. Throws Error(kUnsupported) for a
// dataset that is no lattice, kInvalidArgument for one without arrays or with arrays of both
// samples and cells.
LatticeFileHeader lattice_file_header(const Dataset& dataset);

// The header of a file of levels or boxes for one array of a Cartesian lattice. `whole` as they
// say: samples keep the array's type and scale, else they are float32 values.
LatticeFileHeader lattice_file_header(const Dataset& dataset, const std::string& array,
                                      LatticeContent content, bool whole);

// The bytes of a lattice file of one array and step with such levels: never less than the file has,
// and a few KiB more at most. Cost: that of packing them.
std::int64_t lattice_levels_bytes(const LatticeLevels& levels);

// Writes a lattice file (.h5, docs/formats.md, "Ovoid's HDF5 lattices") step after step; of the
// samples nothing is kept. It goes to a partial file beside `path`, which finish() renames over it;
// without finish(), also after an exception, nothing is left behind and an existing file stays as
// it was, and remove_partial_files() knows the partial one. The options' stop token, triggered,
// makes write_step() and finish() throw Error(kCancelled). One thread at a time; several writers
// may be open. Calls into the HDF5 library are made one at a time.
class LatticeFileWriter {
 public:
  // Throws Error: kInvalidArgument naming the member of the header that is not as it says, a row of
  // more than 1 GiB or a name or unit of more than 4096 bytes; kFileWrite; kUnsupported in a build
  // without HDF5.
  LatticeFileWriter(const std::string& path, LatticeFileHeader header,
                    const WriteOptions& options = {});
  ~LatticeFileWriter();
  LatticeFileWriter(LatticeFileWriter&&) noexcept;
  LatticeFileWriter& operator=(LatticeFileWriter&&) noexcept;

  const LatticeFileHeader& header() const noexcept;
  std::int64_t num_steps() const noexcept;  // written so far
  const LatticeFileCounts& counts() const noexcept;

  // Appends a step: for every array of the header its samples, [dims[2]][dims[1]][dims[0]]
  // [num_components], native byte order. Throws Error: kInvalidArgument for another number of
  // arrays or bytes, kFileWrite (then the writer is of no further use). Cost: compression, about a
  // second for 50 MiB.
  void write_step(std::span<const Bytes> samples);
  // The same with levels of kernels, or boxes, of the header's dims, for every array. They stand
  // for stored numbers, of which the header's scale and offset make values, and are checked as
  // samples_of() checks them, at its cost.
  void write_levels(std::span<const LatticeLevels> levels);
  void write_boxes(std::span<const LatticeBoxes> boxes);
  // The same with the arrays of a dataset, which must be the header's: name, type, components and
  // number of samples. Its geometry and its time are not looked at.
  void write_step(const Dataset& step);

  // Puts the file in its place; nothing may be written afterwards. Throws Error: kInvalidArgument
  // without a step or if the header's times are not as many as the steps; kFileWrite.
  void finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovoid
