// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "serve.h"

namespace ovoid::reader {

// Reads, and leaves out of what is read all arrays with numbers that the file does not hold: a
// library may take memory for what a header names, find nothing there, and say nothing. Memory is
// given out full of one byte; where that is found in an array the file is read once more with
// another, and what differs was never written. Arrays left out are in the notes. Throws what `read`
// throws, and Error(kFileFormat) if places or cells, the array that was asked for, or all arrays
// are such. Only with the GNU C library's own memory; else this is `read`.
Dataset read_what_is_written(const io::ReaderRequest& request, ReadHere read);

}  // namespace ovoid::reader
