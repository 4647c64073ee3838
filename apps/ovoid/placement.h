// SPDX-License-Identifier: Apache-2.0
// Files that say where a volume lies: docs/two-volumes.md, "Registration".
#pragma once

#include <string>

#include "ovoid/dataset.h"
#include "ovoid/math.h"

namespace ovoid::cli {

// The map from the world that a volume's own file names to the world of a picture in `space`, from
// the text of such a file:
//
//   16 or 12 numbers   a matrix, row by row, that does just this; 12: without the last row, which
//   is
//                      0 0 0 1; # begins a comment
//   an ITK transform   of the text format (.tfm, .txt): it leads from points of the fixed image,
//   the
//                      picture, to points of the moving one, the volume, in LPS [ITK transforms]
//
// Throws Error(kInvalidArgument) that names `source` and what is wrong: other transforms than
// translations, rigid, similar and affine ones in three dimensions, numbers that are missing or not
// finite, matrices that cannot be inverted.
Affine3 placement_from_text(const std::string& text, const std::string& source, Space space);

// Of a file. Throws Error(kFileRead), too.
Affine3 read_placement(const std::string& path, Space space);

// From the world of one space to that of another. Patients' spaces differ in the signs of x and y;
// of others nothing is known, they are taken to be the same.
Affine3 between_spaces(Space from, Space to);

}  // namespace ovoid::cli
