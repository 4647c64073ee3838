// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it first
#include <cstdlib>
#include <string>
#include <vector>

#include <jpeglib.h>

#include "io/core/atomic_file.h"
#include "io/pictures/pictures.h"
#include "ovoid/encode.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Neither C++ exceptions nor messages may cross libjpeg: it jumps out.
struct JpegState {
  jpeg_error_mgr errors{};  // first, so that a pointer to it is one to the whole
  jmp_buf jump{};
  char message[JMSG_LENGTH_MAX] = {};
  unsigned char* bytes = nullptr;  // libjpeg's, by malloc
  unsigned long num_bytes = 0;
};

[[noreturn]] void on_jpeg_error(j_common_ptr jpeg) {
  auto* state = reinterpret_cast<JpegState*>(jpeg->err);
  jpeg->err->format_message(jpeg, state->message);
  std::longjmp(state->jump, 1);
}

void on_jpeg_message(j_common_ptr) {}

struct Pixels {
  const std::uint8_t* rgba8;
  int width, height;
};

// Everything between setjmp and a longjmp: no object with a destructor lives here. `rgb` is a row's
// memory.
bool compress(jpeg_compress_struct* jpeg, JpegState* state, Pixels pixels, int quality,
              std::uint8_t* rgb) {
  if (setjmp(state->jump) != 0) return false;
  jpeg_create_compress(jpeg);
  jpeg_mem_dest(jpeg, &state->bytes, &state->num_bytes);
  jpeg->image_width = static_cast<JDIMENSION>(pixels.width);
  jpeg->image_height = static_cast<JDIMENSION>(pixels.height);
  jpeg->input_components = 3;
  jpeg->in_color_space = JCS_RGB;
  jpeg_set_defaults(jpeg);
  jpeg_set_quality(jpeg, quality, TRUE);
  // Colour as fine as brightness: thin coloured lines keep their colour.
  jpeg->comp_info[0].h_samp_factor = jpeg->comp_info[0].v_samp_factor = 1;
  jpeg->optimize_coding = TRUE;
  jpeg_start_compress(jpeg, TRUE);
  for (int row = 0; row < pixels.height; ++row) {
    for (int x = 0; x < pixels.width; ++x, pixels.rgba8 += 4) {
      for (int c = 0; c < 3; ++c) rgb[3 * x + c] = pixels.rgba8[c];
    }
    JSAMPROW rows[] = {rgb};
    jpeg_write_scanlines(jpeg, rows, 1);
  }
  jpeg_finish_compress(jpeg);
  return true;
}

}  // namespace

std::string jpeg_bytes(std::span<const std::uint8_t> rgba8, int width, int height, int quality,
                       const std::string& name) {
  JpegState state;
  jpeg_compress_struct jpeg{};
  jpeg.err = jpeg_std_error(&state.errors);
  state.errors.error_exit = on_jpeg_error;
  state.errors.output_message = on_jpeg_message;
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(width));
  const bool done = compress(&jpeg, &state, {rgba8.data(), width, height}, quality, row.data());
  jpeg_destroy_compress(&jpeg);
  struct Frees {
    unsigned char* bytes;
    ~Frees() { std::free(bytes); }
  } const frees{state.bytes};
  if (!done) {
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: cannot be written: libjpeg: {}", name, state.message));
  }
  return {reinterpret_cast<const char*>(state.bytes), state.num_bytes};
}

void write_jpeg(std::span<const std::uint8_t> rgba8, int width, int height, const std::string& path,
                const std::stop_token& stop) {
  AtomicFile file(path, stop);
  file.write(jpeg_bytes(rgba8, width, height, kUsualJpegQuality, path));
  file.commit();
}

}  // namespace ovoid::io
