// SPDX-License-Identifier: Apache-2.0
// What programs of microscopy write into a TIFF file's description: which page is which slice,
// channel and time step: the lines of [ImageJ], and the XML of [OME 2016].
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/channel.h"
#include "io/images/tiff_file.h"

namespace ovoid::io {

// How a file's pages become slices, channels and time steps.
struct TiffStack {
  std::string name;  // of one of several images in a file
  std::int64_t num_slices = 1, num_channels = 1, num_frames = 1;
  // Of the page in the file that holds the plane z, channel, frame; z fastest, then the channel.
  // Empty: they follow `strides`.
  std::vector<std::int64_t> directories{};
  std::int64_t first = 0;                        // page of the first plane
  std::array<std::int64_t, 3> strides{1, 0, 0};  // pages from slice to slice, channel, frame
  std::vector<Channel> channels{};               // empty: not known
  std::array<std::optional<double>, 3> spacing{};
  std::string length_unit{};
  std::optional<double> frame_interval{};
  std::string time_unit{};
  // Of values: stored x scale + offset, and their unit.
  double value_scale = 1, value_offset = 0;
  std::string value_unit{};
  std::vector<std::string> notes{};  // without the file's name
  // Of arrays whose planes are other than (y, x): the axes (io/core/axis_order.h), pages' own last;
  // empty for all others. The samples along these axes, where they are known.
  std::string order{};
  std::vector<std::int64_t> shape{};

  std::int64_t num_planes() const noexcept { return num_slices * num_channels * num_frames; }
  // The page of a plane, by its number in the file or among its pages.
  std::int64_t page(std::int64_t z, std::int64_t channel, std::int64_t frame) const;
};

// ImageJ's description: "ImageJ=1.53t\nimages=12\nchannels=2\nslices=6\n...". Empty for a file
// without one.
std::optional<TiffStack> imagej_stack(const TiffFile& file);

bool looks_like_ome(std::string_view description) noexcept;

// The images of OME's description, at least one. `file`: the TIFF's own name, for messages and to
// tell planes that lie in other files. Planes are told by directories. Throws Error: kFileFormat
// for sizes that no file has, kUnsupported for planes in other files.
std::vector<TiffStack> ome_stacks(const std::string& file, const std::string& description);

// The program that wrote fields of its own which are not read, in words; empty if none is known.
std::string unread_tiff_program(const TiffFile& file);

}  // namespace ovoid::io
