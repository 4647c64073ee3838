// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "io/core/byte_source.h"
#include "io/core/decode.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads a NIfTI-1 or NIfTI-2 volume, one step of it: .nii, or the .hdr of a pair, whose .img or
// .img.gz `open` finds. `encoding`: of `source`, raw or gzip. The place is the sform's, else the
// qform's (both in RAS), else made of pixdim alone; slope and intercept stay beside the samples.
// Throws Error.
Dataset read_nifti(const ByteSource& source, Encoding encoding, const ReadOptions& options,
                   const Opener& open = open_file);

// The samples' file of the pair whose header is called `header_path`; it need not exist.
std::string nifti_image_path(const std::string& header_path);

// Writes the array as .nii or .nii.gz: NIfTI-1, or NIfTI-2 where an axis is too long for it. World
// coordinates become RAS. An array of components is a vector. Throws Error(kFileWrite,
// kUnsupported).
void write_nifti(const Dataset& dataset, const DataArray& array, const std::string& path,
                 const std::stop_token& stop = {});

// True if write_nifti can say where the lattice lies without calling its space a patient's: it lies
// at the origin, along the axes.
bool is_placed_by_spacing(const LatticeGeometry& lattice);

}  // namespace ovoid::io
