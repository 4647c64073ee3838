// SPDX-License-Identifier: Apache-2.0
// Pictures as the bytes of a file, in memory: for who sends them on.
#pragma once

#include <optional>
#include <string>

#include "ovoid/export.h"
#include "ovoid/image.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// Of the JPEG files that write_image() writes.
inline constexpr int kUsualJpegQuality = 92;

// The bytes of the PNG or JPEG that write_image() writes of the same picture; of a JPEG by another
// `quality`, too, in [1, 100]. Throw Error: kInvalidArgument for an image whose arrays have not the
// sizes that it says, or another quality; kFileWrite for what the format cannot hold (a JPEG's side
// has at most 65500 pixels); kOutOfMemory. Cost: of a megapixel some 100 ms as a PNG, 20 ms as a
// JPEG.
std::string encode_png(const Image& image, const std::optional<Rgb>& background = {});
std::string encode_jpeg(const Image& image, const Rgb& background, int quality = kUsualJpegQuality);

}  // namespace ovoid
