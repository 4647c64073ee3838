// SPDX-License-Identifier: Apache-2.0
// The header of a NIfTI-1 or NIfTI-2 file as it stands, checked number by number, but not yet
// understood as a volume. Sources: [Cox 2004], [NIfTI-2].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "ovoid/lattice.h"

namespace ovoid::io {

// Bytes of the headers, and of the four that follow them in a single file and say whether
// extensions do.
inline constexpr std::size_t kNifti1Size = 348;
inline constexpr std::size_t kNifti2Size = 540;
inline constexpr std::size_t kNiftiExtenderSize = 4;

struct NiftiHeader {
  int version = 1;
  bool is_big_endian = false;
  bool is_pair = false;                                   // the samples are in a file of their own
  std::array<std::int64_t, 7> dims{1, 1, 1, 1, 1, 1, 1};  // x y z t components, each >= 1
  ScalarType type = ScalarType::kUInt8;
  int num_channels = 1;                // values of one sample that lie together: colours
  std::array<double, 8> pixdim{};      // [0] is qfac, [1] to [4] are steps along x y z t
  std::int64_t vox_offset = 0;         // bytes before the samples
  double slope = 0, intercept = 0;     // of the values; a slope of 0 says that there is none
  int qform_code = 0, sform_code = 0;  // > 0: there is such a transform
  std::array<double, 3> quaternion{};  // b c d
  std::array<double, 3> qform_offset{};
  std::array<std::array<double, 4>, 3> sform{};  // rows of world_from_index
  int units = 0;
  double time_offset = 0;
  std::string intent_name;

  std::size_t size() const noexcept { return version == 1 ? kNifti1Size : kNifti2Size; }
};

// From the first bytes of a file, at least kNifti1Size of them.
bool looks_like_nifti(std::string_view start) noexcept;
// The same header without NIfTI's magic, as its predecessor has it.
bool looks_like_analyze(std::string_view start) noexcept;

// `bytes`: the first ones of the file called `name`, kNifti2Size if there are as many. Throws
// Error(kFileFormat, kUnsupported) naming file and field.
NiftiHeader parse_nifti_header(const std::string& name, std::string_view bytes);

// The code of a type, the number of bits that goes with it.
int nifti_code_of(ScalarType type) noexcept;

}  // namespace ovoid::io
