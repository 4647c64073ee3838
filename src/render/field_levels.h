// SPDX-License-Identifier: Apache-2.0
// Which field a frame draws: itself, or a coarser one where a picture has far fewer pixels than the
// data has samples (docs/numerics.md, "Levels of a lattice").
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/render_options.h"

namespace ovoid {

// How often the spacing of a lattice can be doubled until the next time would make it wider than a
// pixel, anywhere in the picture; 0 for what has no levels.
int coarsest_level(const Field& field, const Camera& camera, const RenderOptions& options);

// Keeps the coarser fields of the few fields that were drawn last: viewers go to and fro between a
// field and its own coarse ones.
class FieldLevels {
 public:
  // The field that is `level` times coarser, or the coarsest that there is: one that would take
  // more memory than the field does is not made. Valid until the next call. Makes what is missing:
  // a pass over the samples. Throws Error(kCancelled), and what the field's source throws.
  const Field& at(const Field& field, int level, int threads, const std::stop_token& stop);

 private:
  struct Pyramid {
    std::uint64_t id, version;   // of the field
    std::vector<Field> coarser;  // [0] is once coarser
  };
  std::vector<Field>& pyramid_of(const Field& field);

  std::vector<Pyramid> kept_;  // the last used first
};

}  // namespace ovoid
