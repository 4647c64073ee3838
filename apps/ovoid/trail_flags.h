// SPDX-License-Identifier: Apache-2.0
// --motion-blur: what was there some time ago, behind what is.
#pragma once

#include <optional>
#include <string>

#include "flags.h"
#include "model_flags.h"
#include "ovoid/renderer.h"
#include "ovoid/series.h"
#include "session.h"

namespace ovoid::cli {

struct TrailFlags {
  std::optional<double> length;
  double decay = 0;
  std::string file;       // its look, a name or JSON itself; empty: made from the picture's
  std::string file_name;  // which look of the file; empty: the first
};

void add_trail_flags(Flags& flags, TrailFlags* trail);
// Throws UsageError for contradictions.
void check_trail_flags(const Flags& flags, const TrailFlags& trail, Mode mode,
                       PostConvolution post_convolution);

// The trail that ends at a time, for a picture with that look of a field with those values. Throws
// Error.
Trail make_trail(const TrailFlags& flags, const Series& series, double time,
                 const ModelFlags& model, int threads, const Look& look, const ValueRange& values,
                 Session& session);

}  // namespace ovoid::cli
