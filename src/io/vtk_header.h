// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/byte_source.h"

namespace ovoid::io {

// VTK's readers believe what a file claims and allocate it. These look at the file first, without
// VTK, and throw where it cannot hold what it says: Error(kFileFormat) naming file, array, what is
// stored and what is needed; Error(kUnsupported) if the file is well-formed but no image. Nothing
// is allocated in proportion to a claim. A file that passes may still be broken inside.

enum class VtkGrid { kImage, kRectilinear };

// XML image data (.vti) or rectilinear grid (.vtr): extents and pieces, numbers of the image's
// place, what every stored array states and whether its bytes or numbers are there, and the ratios
// its compressor can reach.
VtkGrid check_vti(const ByteSource& source);

// Legacy structured points or rectilinear grid (.vtk): dimensions, number of samples and
// coordinates, and every array to the end.
VtkGrid check_legacy_vtk(const ByteSource& source);

}  // namespace ovoid::io
