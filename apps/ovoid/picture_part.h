// SPDX-License-Identifier: Apache-2.0
// What several processes that draw one picture must agree about, and how one of them draws its
// part.
#pragma once

#include <string>

#include "drawing.h"
#include "ovoid/io.h"
#include "values.h"

namespace ovoid::cli {

// All that a picture depends on, in lines "NAME VALUE": processes with the same lines draw parts of
// one picture.
std::string picture_lines(const Scene& scene, const Camera& camera, const RenderOptions& options);

// The same of the files that it is of, before they are read: their lengths, and some of their
// bytes. Throws Error(kFileNotFound).
std::string data_lines(const std::vector<std::string>& inputs);

// The name of the first line in which two such texts differ: "camera"; empty if they do not.
std::string differing_line(const std::string& a, const std::string& b);

// Tells what the frame has to say. Throws Error.
PicturePart draw_part(Renderer& renderer, const Scene& scene, const Camera& camera,
                      RenderOptions options, const PartChoice& choice, const RenderHooks& hooks,
                      Session& session);

// The picture of all parts, with the colours of integrals where it is for eyes.
Image picture_of(const DeepImage& seen, Look look, const LookFlags& flags, bool is_for_eyes,
                 Session& session);

}  // namespace ovoid::cli
