// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "io/images/slice_pictures.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads a TIFF whose pages are the slices of a volume: of one size and type, integers or floats,
// plain or packed by LZW, deflate, Zstandard, PackBits or JPEG. ImageJ's, OME's and tifffile's
// descriptions say which page is which slice, channel (an array each) and time step (one is read),
// and the spacing; options.raw.axis_order says another order of pages, height, width and colours.
// Colours are components. options.raw.spacing goes before the file's. Of OME's images one is read:
// options.block, else the one with most planes. Where pages lie behind each other as in raw data,
// the samples may stay in the file. Throws Error: kFileFormat naming page and field, kUnsupported,
// kInvalidArgument.
Dataset read_tiff(const ByteSource& source, const ReadOptions& options);

// Pictures of one page.
SliceReader tiff_slices() noexcept;

}  // namespace ovoid::io
