// SPDX-License-Identifier: Apache-2.0
// A frame of a lattice field: plan on the host, then all of it on the device.
#pragma once

#include <memory>
#include <vector>

#include "render/vulkan/device_lattice.h"
#include "render/vulkan/frame_constants.h"
#include "render/vulkan/workbench.h"
#include "view/behind.h"

namespace ovoid::vulkan {

class LatticeRenderer {
 public:
  explicit LatticeRenderer(Workbench& bench) : bench_(bench) {}

  // Draws into `image`, which is empty, and counts in `profile`.
  void render(const LatticeField& field, const Camera& camera, const Look& look,
              const RenderOptions& options, const RenderHooks& hooks, const view::Behind* behind,
              Image& image, FrameProfile& profile);

  // After a frame that was broken off: what is on the device of relevance may be half done.
  void forget_relevance() { kept_.bytes = kept_behind_.bytes = {}; }

 private:
  // A field on the device, and which of its bricks can show.
  struct Kept {
    std::unique_ptr<DeviceLattice> lattice;
    Buffer bricks, other_bricks;
    std::vector<std::uint8_t> bytes;  // of `bricks`, before distances
  };
  struct Drawn {
    const LatticeField* field = nullptr;
    const Look* look = nullptr;
    view::LatticePlan plan;
    Kept* kept = nullptr;
  };

  void keep(Kept& kept, const LatticeField& field, const view::LatticePlan& plan,
            std::uint64_t most_bytes);
  void decide_relevance(Kept& kept, view::LatticePlan& plan, const RenderOptions& options);

  Workbench& bench_;
  Kept kept_, kept_behind_;
  Buffer frame_, tables_, counts_, nothing_;
};

}  // namespace ovoid::vulkan
