// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>

#include "data/out_of_memory.h"
#include "io/core/atomic_file.h"
#include "io/pictures/pictures.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Take = std::function<void(const void* bytes, std::size_t size)>;

// What libpng's callbacks need. Neither C++ exceptions nor messages may cross libpng: they are kept
// here and it jumps out.
struct PngState {
  const Take* take = nullptr;
  std::exception_ptr write_error;
  std::string message;
  std::size_t refused_bytes = 0;  // of memory
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  if (state->message.empty()) state->message = message;
  png_longjmp(png, 1);
}

png_voidp on_allocate(png_structp png, png_alloc_size_t size) {
  void* const memory = std::malloc(size);
  if (memory == nullptr) static_cast<PngState*>(png_get_mem_ptr(png))->refused_bytes = size;
  return memory;
}

void on_free(png_structp, png_voidp memory) { std::free(memory); }

void on_warning(png_structp, png_const_charp) {}

void on_write(png_structp png, png_bytep data, png_size_t size) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  try {
    (*state->take)(data, size);
    return;
  } catch (...) {
    state->write_error = std::current_exception();
  }
  png_error(png, "write failed");
}

// Everything between setjmp and a longjmp: no object with a destructor lives here.
bool encode(png_structp png, png_infop info, PngState* state, const std::uint8_t* rgba8, int width,
            int height) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, state, on_write, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
               PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  for (int row = 0; row < height; ++row) {
    png_write_row(png, rgba8 + static_cast<std::size_t>(row) * static_cast<std::size_t>(width) * 4);
  }
  png_write_end(png, info);
  return true;
}

// `name` stands in messages.
void put_png(std::span<const std::uint8_t> rgba8, int width, int height, const std::string& name,
             const Take& take) {
  PngState state{&take, nullptr, {}};
  png_structp png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, &state, on_error, on_warning,
                                              &state, on_allocate, on_free);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool done = info != nullptr && encode(png, info, &state, rgba8.data(), width, height);
  if (png != nullptr) png_destroy_write_struct(&png, info != nullptr ? &info : nullptr);
  if (state.write_error) std::rethrow_exception(state.write_error);
  if (!done && state.refused_bytes > 0)
    data::throw_out_of_memory(name + ": libpng", state.refused_bytes);
  if (!done)
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: cannot be written: libpng: {}", name, state.message));
}

}  // namespace

std::string png_bytes(std::span<const std::uint8_t> rgba8, int width, int height,
                      const std::string& name) {
  std::string bytes;
  put_png(rgba8, width, height, name, [&bytes](const void* more, std::size_t size) {
    bytes.append(static_cast<const char*>(more), size);
  });
  return bytes;
}

void write_png(std::span<const std::uint8_t> rgba8, int width, int height, const std::string& path,
               const std::stop_token& stop) {
  AtomicFile file(path, stop);
  put_png(rgba8, width, height, path,
          [&file](const void* bytes, std::size_t size) { file.write(bytes, size); });
  file.commit();
}

}  // namespace ovoid::io
