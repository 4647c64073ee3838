// SPDX-License-Identifier: Apache-2.0
// Which triangles of a surface are seen in which pixels, and how far away: fragments, for tiles of
// a picture that are independent of each other.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/render_options.h"
#include "ovoid/surface.h"
#include "render/passes/picture_tiles.h"

namespace ovoid {

// A triangle's part of a pixel.
struct SurfaceFragment {
  std::uint32_t triangle = 0;
  std::uint8_t covered = 0;              // bit i: the pixel's place i lies in it
  std::int8_t enters = 0;                // 1: a ray comes into the mesh here, -1: leaves it, or 0
  float depth = 0;                       // along the view axis, in the middle of what is covered
  std::array<float, 3> shares{};         // of the corners there; they add up to 1
  std::array<float, 3> edge_distance{};  // pixels, from the side that begins at each corner
};

class SurfaceRaster {
 public:
  static constexpr int kTile = TileLists::kTile;
  static constexpr int kPlaces = 4;  // of a pixel that are looked at
  // A square of side 1 / sqrt(5) turned by atan(1/2): no two places in a row or column.
  static constexpr std::array<std::array<double, 2>, kPlaces> kPlacesInPixel = {
      {{0.375, 0.125}, {0.875, 0.375}, {0.625, 0.875}, {0.125, 0.625}}};

  enum class Faces {
    kDrawn,  // those with values, where no clip plane cuts them away
    kAll,
  };
  // Sorts triangles into tiles. The camera is valid. What lies behind the eye is left out.
  SurfaceRaster(const Surface& surface, const Camera& camera, const RenderOptions& options,
                Faces faces);

  int num_tiles() const noexcept { return tiles_.num_tiles(); }
  // First pixel of a tile.
  int tile_x(int tile) const noexcept { return tiles_.tile_x(tile); }
  int tile_y(int tile) const noexcept { return tiles_.tile_y(tile); }

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }

  // Fragments of a tile's pixels, each pixel's from front to back. `is_opaque`: what is hidden by
  // something nearer at every place may be missing.
  struct TileFragments {
    std::vector<SurfaceFragment> fragments;
    std::array<std::uint32_t, kTile * kTile + 1> first{};  // of pixel y * kTile + x
    std::span<const SurfaceFragment> of_pixel(int x, int y) const {
      const auto at = static_cast<std::size_t>(y) * kTile + static_cast<std::size_t>(x);
      return {fragments.data() + first[at], fragments.data() + first[at + 1]};
    }
  };
  TileFragments tile_fragments(int tile, bool is_opaque) const;

  // origin + depth * direction lies at that depth along the view axis.
  struct Ray {
    Vec3 origin, direction;
  };
  // Through a pixel's place.
  Ray ray_through(int x, int y, int place) const;
  // Where the ray through a place that the fragment covers meets its triangle.
  float depth_at(const SurfaceFragment& fragment, int x, int y, int place) const;
  Vec3 place_of(const SurfaceFragment& fragment) const;
  // Unit length, towards the eye.
  Vec3 towards_eye(const Vec3& place) const;

 private:
  // In the picture: pixels from its left and top, and 1 / depth (parallel: the depth itself).
  struct Corner {
    double x, y, z;
  };
  // A triangle, or a part of one that the near plane has cut: what its corners are of the whole's.
  struct Part {
    std::uint32_t triangle;
    bool is_cut;
    std::array<Corner, 3> corners;
    std::array<std::array<float, 3>, 3> shares;  // of cut ones: of the triangle's own corners
  };

  void add_triangle(std::uint32_t number);
  Corner corner_of(const Vec3& view) const;
  void add_part(const Part& part);
  void rasterize(const Part& part, int tile, bool is_opaque, struct TileWork& work) const;

  const Surface& surface_;
  bool is_parallel_;
  Vec3 eye_, right_, up_, axis_;
  double scale_;  // pixels per tangent, or per world length
  double near_;
  int width_, height_;
  TileLists tiles_;
  Faces faces_;
  std::vector<ClipPlane> clip_planes_;  // of drawn faces
  std::vector<Part> parts_;
};

}  // namespace ovoid
