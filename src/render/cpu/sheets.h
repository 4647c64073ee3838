// SPDX-License-Identifier: Apache-2.0
// The sheets that a tile keeps at a time, of either kind of field.
#pragma once

#include <hwy/aligned_allocator.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace ovoid::cpu {

inline constexpr int kTileSize = 32;  // pixels: two of the largest SIMD groups, which have 16
                                      // lanes; larger tiles read fewer kernels twice, but not from
                                      // the L1 cache
inline constexpr int kMaxMargin = 1;

using RowWord = std::uint64_t;  // bit x for sample x

// The bits of samples 0 to count - 1; count < 64.
constexpr RowWord first_bits(int count) noexcept { return (RowWord{1} << count) - 1; }

inline constexpr int kMaxPlaneRows = 56;
using RowBits = std::array<RowWord, kMaxPlaneRows>;  // of the rows that a plane has; the others are
                                                     // nobody's

// How the samples of one sheet are kept: sample (x, y) at y * stride + x.
struct PlaneShape {
  int rows, stride;

  // A group at a plane's end reads and writes on.
  constexpr std::size_t num_floats() const {
    constexpr std::size_t kGroup = 16;
    return (static_cast<std::size_t>(rows) * static_cast<std::size_t>(stride) + 2 * kGroup - 1) /
           kGroup * kGroup;
  }
};

// The pixels of a tile and the margin around them.
inline constexpr PlaneShape kTilePlane{kTileSize + 2 * kMaxMargin, 48};

// What is known of the samples of one sheet.
struct Sheet {
  int stride = 0;
  float* values = nullptr;
  float* colors = nullptr;           // of the attribute that gives the colour, if another one does
  std::array<float*, 3> gradient{};  // along the world's axes, in FramePlan::gradient_unit; a
                                     // piece's stands at the sample that it ends at
  float* opacity = nullptr;  // by the look, and how much it varies up to the value; for pieces
  float* variation = nullptr;
  float* around = nullptr;  // how much of the light around and of the key arrives; for pieces
  float* key = nullptr;
  RowBits defined{};  // samples that have a value
  RowBits has_gradient{};
  RowBits is_classified{};  // that have an opacity and a variation
  RowBits has_light{};      // that know how much light arrives

  int at(int column, int row) const noexcept { return row * stride + column; }
  void clear() noexcept { defined = has_gradient = is_classified = has_light = {}; }
};

// The last sheets of a tile. They go by their numbers in the frame, whichever block brought them.
class SheetRing {
 public:
  static constexpr int kSheets = 4;  // a power of two: differences on a sheet and on the one before

  // Throws Error(kOutOfMemory).
  explicit SheetRing(const PlaneShape& shape);

  Sheet& operator[](std::int64_t sheet) noexcept { return sheets_[slot_of(sheet)]; }
  const Sheet& operator[](std::int64_t sheet) const noexcept { return sheets_[slot_of(sheet)]; }

 private:
  static std::size_t slot_of(std::int64_t sheet) noexcept {
    return static_cast<std::size_t>(sheet & (kSheets - 1));
  }

  hwy::AlignedFreeUniquePtr<float[]> memory_;
  std::array<Sheet, kSheets> sheets_;
};

}  // namespace ovoid::cpu
