// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ovoid/image.h"

namespace ovoid::experiments {

// A picture with nothing in it.
Image blank(int width, int height);

// Side by side, of one height, with a white gap.
Image side_by_side(const std::vector<Image>& images);

// The square of `side` pixels at (x, y), every pixel `factor` times as large.
Image magnified(const Image& image, int x, int y, int side, int factor);

// Brightness stretched about its mean over the picture: `gain` times as much contrast.
Image stretched(const Image& image, double gain);

// A PNG on white.
void write_figure(const Image& image, const std::string& path);

}  // namespace ovoid::experiments
