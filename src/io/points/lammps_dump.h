// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads one frame of a text dump of LAMMPS, also within gzip or bzip2: options.step, or the first
// whose array varies. Frames are steps; their time is what ITEM: TIME says, else the time step's
// number. The whole file is walked once to count them; other frames are not kept. Numbers become
// float64. Positions are x y z, else xu yu zu, else xs ys zs or xsu ysu zsu, which are brought into
// the box. Throws Error.
Dataset read_lammps_dump(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
