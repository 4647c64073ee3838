// SPDX-License-Identifier: Apache-2.0
// A frame of a lattice field: plan on the host, then all of it on the device.
#pragma once

#include <memory>
#include <vector>

#include "render/back_end.h"
#include "render/shared/lattice_values.h"
#include "render/vulkan/device_lattice.h"
#include "render/vulkan/workbench.h"

namespace ovoid::vulkan {

class LatticeRenderer {
 public:
  explicit LatticeRenderer(Workbench& bench) : bench_(bench) {}

  // Draws into `image`, which is empty, and counts in `profile`.
  void render(const FrameJob& frame, Image& image, FrameProfile& profile);

  // After a frame that was broken off: what is on the device of relevance may be half done.
  void forget_relevance() { kept_.bytes = kept_trail_.bytes = {}; }

 private:
  // A field on the device, and which of its bricks can show.
  struct Kept {
    std::unique_ptr<DeviceLattice> lattice;
    Buffer bricks, other_bricks;
    std::vector<std::uint8_t> bytes;  // of `bricks`, before distances
  };
  struct Drawn;
  struct Job;

  void keep(Drawn& drawn, const BoxCut& cut, bool must_equal);
  void decide_relevance(Drawn& drawn, const RenderOptions& options);
  void upload(Job& job);
  bool gathers_gradients(const Job& job) const;
  void set_constants(Job& job);
  void divide_sheets(Job& job) const;
  void draw_box(const Job& job, std::size_t number, const Strip& strip);

  Workbench& bench_;
  Kept kept_, kept_trail_;
  Buffer frame_, tables_, counts_, nothing_;
};

}  // namespace ovoid::vulkan
