// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/deep_image.h"
#include "ovoid/devices.h"
#include "ovoid/export.h"
#include "ovoid/image.h"
#include "ovoid/kernel_team.h"
#include "ovoid/render_options.h"
#include "ovoid/scene.h"

namespace OVOID_API ovoid {

// kAuto: vulkan where there is a hardware device, else cpu; and cpu, with a notice, for what the
// device fails to draw.
enum class Backend { kAuto, kCpu, kVulkan, kReference };

// A feature of scenes and options, and which back ends draw it. What a device does not draw is
// drawn by the cpu under kAuto, with a notice; asked for by name, a back end refuses it. Points,
// opaque walls and surfaces without volumes are drawn by the host alone, whatever the back end.
struct BackEndFeature {
  const char* name;  // as messages have it
  bool by_reference, by_cpu, by_vulkan;
};
// All of them, in an order for people.
std::span<const BackEndFeature> back_end_features();

// A finished rectangle of the picture, passed to the tile sink while the rest is still drawn.
struct TileDone {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels, half open
  const Image* image = nullptr;        // the picture so far; only this rectangle of it may be read
};

// Ways to watch and to stop a frame. Callbacks come from worker threads, one at a time. An
// exception that one throws ends the frame: none is called again, and render() throws it on when
// the tiles under way are done. The renderer can draw again.
struct RenderHooks {
  std::stop_token stop;  // triggered: render throws Error(kCancelled) within a block's time
  std::function<void(double fraction)> progress;  // in [0, 1], not decreasing
  std::function<void(const TileDone&)> tile_done;
  // Processes that draw the same frame at the same time, each a part of its own: they make together
  // what is of the whole, light from a coarse volume. If one does not render, the others wait for
  // it. Null: alone.
  std::shared_ptr<KernelTeam> team;
};

// Counts and times of one frame.
struct FrameProfile {
  std::string backend;      // "cpu", "vulkan", "reference"
  std::string device;       // of vulkan: its name
  std::string simd_target;  // "AVX2", ...; empty for the reference
  std::string notice;       // what was drawn otherwise than asked for, and why: by the cpu instead
                            // of the device that kAuto found, in another precision, by fewer
                            // threads; empty: nothing
  int threads = 1;
  double frame_ms = 0;  // plan to finish, wall clock
  // Summed over threads, in pipeline order; empty without collect_profile.
  std::vector<std::pair<std::string, double>> stages_ms;
  std::int64_t kernels_total = 0;
  std::int64_t kernels_drawn = 0;  // kernels in bricks that can meet a non-zero opacity
  // Loaded for some block; one that several blocks share counts for each.
  std::int64_t kernels_loaded = 0;
  std::int64_t samples_reconstructed = 0;
  std::int64_t samples_shaded = 0;  // samples with a non-zero opacity
  std::int64_t base_samples = 0;    // of the base plane that lattice sheets are drawn on; 0: none
  std::int64_t gradients = 0;       // samples whose gradient was taken
  // Of the cpu back end on lattices: what the values and gradients needed in the stages reconstruct
  // and gradient, and what one thread can do per second with simd_target where nothing is in its
  // way (0 without collect_profile). How much of that is reached tells how far the stages are from
  // the machine's limit.
  double multiply_adds = 0;
  double multiply_add_peak = 0;
  // Of the same: what the stage load reads of samples as they are stored (one that several blocks
  // share counts for each), and what one thread can read per second, in order, from memory.
  double bytes_loaded = 0;
  double bandwidth_peak = 0;
  std::int64_t bytes_uploaded = 0;  // to a device: what of field, look and camera it did not have
  std::int64_t blocks_total = 0;    // these four: of the cpu back end
  std::int64_t blocks_drawn = 0;
  // No kernel reaches the block (outside the field, or clipped).
  std::int64_t blocks_skipped_empty = 0;
  std::int64_t blocks_skipped_irrelevant = 0;  // the field cannot meet a non-zero opacity there
  std::int64_t blocks_skipped_opaque = 0;      // every pixel had stopped
};

struct Frame {
  Image image;
  FrameProfile profile;
  // Of a part of space (RenderOptions::part): runs of sheets, to be put together with those of the
  // other parts. Then `image` has the pixels of these runs alone, colours or values as they have.
  std::optional<DeepImage> seen;
};

// What a renderer runs on.
struct RendererSetup {
  Backend backend = Backend::kAuto;
  int threads = 0;  // of the host; 0: one per hardware thread
  // By DeviceInfo::index; -1: the first hardware device, else the first. kVulkan alone.
  int device = -1;
  std::uint64_t device_memory = 0;   // bytes that fields may take there; 0: most of it. Larger ones
                                     // are drawn piece by piece.
  bool auto_takes_software = false;  // kAuto draws with software devices, too
  std::string simd_target{};         // of kCpu: one of simd_targets(); empty: the best
  VulkanSetup vulkan{};
};

// Draws scenes. Holds what outlives a frame: worker threads, and what a back end keeps of a field.
// One render() at a time per renderer; several renderers may be used from several threads.
class Renderer {
 public:
  // Throws Error: kInvalidArgument, also for a device where none draws and for a SIMD target that
  // is not there; kUnsupported if kVulkan is asked for and there is no loader, no device, or none
  // that has what is needed.
  explicit Renderer(const RendererSetup& setup);
  explicit Renderer(Backend backend = Backend::kAuto, int threads = 0)
      : Renderer(RendererSetup{.backend = backend, .threads = threads}) {}
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  int threads() const noexcept;  // of the host that it would use; the system may grant fewer

  // One picture: render({field, look}, camera) of one volume. The same arguments give the same
  // bytes, whatever the number of threads. Surfaces, slices, labels and the boundary of a mesh are
  // found by the host and come into the frame as depth limits (RenderOptions::depth_limits), which
  // they join; points, opaque walls and surfaces without volumes are drawn by the host alone.
  // Outlines are smooth. A depth is where opacity first reaches 1/2, the front depth where
  // something first is seen. Counts of the profile are of all that is drawn for the picture. Throws
  // Error: kInvalidArgument for an invalid scene, camera or options; kUnsupported for what is not
  // drawn together, or not by the back end; kCancelled; kOutOfMemory; what the field's brick source
  // throws. Cost: in proportion to the visible, relevant samples; of surfaces to their triangles
  // and the pixels that they cover, of a slice or value plane one sheet of samples, of labels about
  // that of an isosurface of their size.
  Frame render(const Scene& scene, const Camera& camera, const RenderOptions& options = {},
               const RenderHooks& hooks = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Names of the SIMD targets that this build has and this machine can run, best first.
std::vector<std::string> simd_targets();

}  // namespace ovoid
