// SPDX-License-Identifier: Apache-2.0
// Samples of a lattice that a lattice file holds as runs, levels or boxes (docs/formats.md,
// "Ovoid's HDF5 lattices").
#pragma once

#include <string>
#include <vector>

#include "io/foreign/hdf5_objects.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Where an array's step is stored. All outlive the call that they are for.
struct Hdf5Packed {
  const Hdf5Objects& objects;
  hid_t group;
  const std::string& place;  // of the group
  const Index3& dims;        // of the lattice
  const ReadOptions& options;
};

// All samples of the array that `description` describes but for type and samples; `notes` gets how
// they are stored. Throws Error: kFileFormat for what contradicts itself, kUnsupported for more
// samples than a file of that size is believed to hold, kCancelled.
DataArray samples_of_runs(const Hdf5Packed& packed, DataArray description, ReadProgress& progress,
                          std::vector<std::string>* notes);
DataArray samples_of_levels(const Hdf5Packed& packed, DataArray description, ReadProgress& progress,
                            std::vector<std::string>* notes);
DataArray samples_of_boxes(const Hdf5Packed& packed, DataArray description, ReadProgress& progress,
                           std::vector<std::string>* notes);

}  // namespace ovoid::io
