// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <string>

#include "io/core/atomic_file.h"
#include "io/pictures/exr_stream.h"
#include "io/pictures/pictures.h"
#include "ovoid/error.h"

namespace ovoid::io {
void write_exr(const Image& image, const std::string& path, const std::stop_token& stop) {
  check_writable(path);
  ExrStream stream(path);
  try {
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer frame;
    const auto width = static_cast<std::size_t>(image.width);
    // OpenEXR's slices take a pointer to non-const and only read from it.
    const auto add = [&](const char* name, const float* first, std::size_t stride) {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(first)),
                                    stride * sizeof(float), stride * width * sizeof(float)));
    };
    for (std::size_t i = 0; i < 4; ++i)
      add(std::string(1, "RGBA"[i]).c_str(), image.rgba.data() + i, 4);
    add("Z", image.front_depth.data(), 1);
    add("half_opacity.Z", image.depth.data(), 1);
    if (!image.normals.empty()) {
      for (std::size_t a = 0; a < 3; ++a)
        add((std::string("N.") + "XYZ"[a]).c_str(), image.normals.data() + a, 3);
    }
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    // As many rows as are packed at once, between two looks at the token.
    constexpr int kRows = 16;
    for (int row = 0; row < image.height; row += kRows) {
      check_stop(stop);
      file.writePixels(std::min(kRows, image.height - row));
    }
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: cannot be written: OpenEXR: {}", path, error.what()));
  }
  write_atomically(path, stream.bytes(), stop);
}

}  // namespace ovoid::io
