// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/reader/reader_messages.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// Reads an OpenVDB file in this process: grids of numbers as a lattice, or points as particles. As
// read_here(), of which this is the one reader in a program of its own. The lattice is the box of
// all voxels that are active in one of its grids, and one voxel more on every side, where the
// background begins. Behind the file to read, request.paths has the files of the series that it is
// one of, itself among them, if it is: the lattice is then that of all of them. Throws Error.
Dataset read_vdb_here(const ReaderRequest& request);

}  // namespace ovoid::io
