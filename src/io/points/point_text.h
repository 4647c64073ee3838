// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads a table of points as text: a point per line, or, where there are few long lines, a quantity
// per line (docs/formats.md, "CSV and other text"). Numbers become float64. Peak memory is that of
// the arrays and, per line, of the line. Throws Error.
Dataset read_point_text(const ByteSource& source, const ReadOptions& options);

// Writes particles as CSV, numbers as short as they can be without loss: x,y,z, then the arrays,
// whose components are called NAME:0, NAME:1 ...; units stand in brackets behind the names. Missing
// values are nan. Throws Error(kFileWrite).
void write_point_text(const Dataset& dataset, const std::string& path,
                      const std::stop_token& stop = {});

}  // namespace ovoid::io
