// SPDX-License-Identifier: Apache-2.0
// Datasets of HDF5 files as chunked arrays, whose chunks the library reads.
#pragma once

#include <memory>
#include <mutex>

#include "io/core/chunked_array.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_storage.h"

namespace ovoid::io {

// What reading takes, of threads in turn: the library is built for one.
struct Hdf5Reading {
  std::mutex mutex;
  ReadProgress progress;
};

// Sets type, byte order, fill value and read() of an array whose shape and chunk are set. Along an
// axis that is longer than the dataset's the rest holds the fill value. The dataset went through
// check_hdf5_storage(); `reading` outlives the array.
void read_chunks_of_hdf5(const std::shared_ptr<const Hdf5Handle>& dataset, const Hdf5Extent& extent,
                         Hdf5Reading& reading, ChunkedArray& array);

}  // namespace ovoid::io
