// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/image.h"
#include "ovoid/look.h"

namespace ovoid {

enum class Backend { kAuto, kCpu, kReference };

// What a sample stands for: the field on its slab's middle plane, or the slab's mean (docs/numerics.md, "Slabs").
enum class Slab { kMid, kMean };

// Where the gradient comes from: the kernels' own derivative, or central differences over neighbouring samples.
enum class GradientMethod { kExact, kCentral };

// How the cpu back end evaluates a block: each sample sums its kernels, each kernel adds to its samples, or the cheaper of both.
enum class Evaluate { kAuto, kGather, kScatter };

// A half space: points with dot(normal, x) >= offset are kept (world). `normal` need not have unit length.
struct ClipPlane {
  Vec3 normal{1, 0, 0};
  double offset = 0;
};

// What one frame is computed from beside field, camera and look. The default is valid.
struct RenderOptions {
  int width = 1024;                          // pixels, 1 to kMaxImageSide
  int height = 768;
  double sampling_distance = 0.0;            // distance of sheets, world units; 0: the field's default
  Slab slab = Slab::kMid;
  GradientMethod gradient = GradientMethod::kExact;
  Evaluate evaluate = Evaluate::kAuto;
  std::vector<ClipPlane> clip_planes;        // at most kMaxClipPlanes
  bool skip_irrelevant = true;               // off: every block is reconstructed (time changes, pixels do not)
  bool stop_opaque = true;                   // off: covered samples are still reconstructed (time changes, pixels do not)
  bool collect_profile = false;              // stage times cost a few per cent

  static constexpr int kMaxImageSide = 32768;
  static constexpr int kMaxClipPlanes = 16;
  static constexpr double kOpaque = 1.0 - 1.0 / 1024.0;  // a pixel takes no sample once its opacity has reached this

  // Throws Error(kInvalidArgument) that names the member.
  void validate() const;
};

// A finished rectangle of the picture, passed to the tile sink while the rest is still drawn.
struct TileDone {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;        // pixels, half open
  const Image* image = nullptr;              // the picture so far; only this rectangle of it may be read
};

// Ways to watch and to stop a frame. Callbacks come from worker threads, one at a time.
struct RenderHooks {
  std::stop_token stop;                                 // triggered: render throws Error(kCancelled) within a block's time
  std::function<void(double fraction)> progress;        // in [0, 1], not decreasing
  std::function<void(const TileDone&)> tile_done;
};

// Counts and times of one frame.
struct FrameProfile {
  std::string backend;                                  // "cpu", "reference"
  std::string simd_target;                              // "AVX2", ...; empty for the reference
  int threads = 1;
  double frame_ms = 0;                                  // plan to finish, wall clock
  std::vector<std::pair<std::string, double>> stages_ms;  // summed over threads, in pipeline order; empty without collect_profile
  std::int64_t kernels_total = 0;
  std::int64_t kernels_drawn = 0;                       // kernels in bricks that can meet a non-zero opacity
  std::int64_t kernels_loaded = 0;                      // loaded for some block; one that several blocks share counts for each
  std::int64_t samples_reconstructed = 0;
  std::int64_t samples_shaded = 0;                      // samples with a non-zero opacity
  std::int64_t gradients = 0;                           // samples whose gradient was taken
  std::int64_t blocks_total = 0;
  std::int64_t blocks_drawn = 0;
  std::int64_t blocks_skipped_empty = 0;                // no kernel reaches the block (outside the field, or clipped)
  std::int64_t blocks_skipped_irrelevant = 0;           // the field cannot meet a non-zero opacity there
  std::int64_t blocks_skipped_opaque = 0;               // every pixel had stopped
};

struct Frame {
  Image image;
  FrameProfile profile;
};

// Draws fields. Holds what outlives a frame: worker threads, and what a back end keeps of a field. One render() at a time per
// renderer; several renderers may be used from several threads.
class Renderer {
 public:
  // `threads` 0: one per hardware thread. Throws Error(kInvalidArgument).
  explicit Renderer(Backend backend = Backend::kAuto, int threads = 0);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // One picture. The same arguments give the same bytes, whatever the number of threads. Throws Error: invalid camera,
  // look or options; kCancelled; what the field's brick source throws. Cost: in proportion to the visible, relevant samples.
  Frame render(const Field& field, const Camera& camera, const Look& look, const RenderOptions& options = {},
               const RenderHooks& hooks = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Names of the SIMD targets that this build has and this machine can run, best first. OVOID_TARGET=name forces one.
std::vector<std::string> simd_targets();

}  // namespace ovoid
