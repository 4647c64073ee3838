// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <string>
#include <vector>

#include "io/images/slice_pictures.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Neither C++ exceptions nor messages may cross libpng: the file is in memory, and errors jump.
struct PngInput {
  std::string bytes;
  std::size_t at = 0;
  std::string_view name;
  char message[256] = {};
};

[[noreturn]] void on_png_error(png_structp png, png_const_charp text) {
  auto* input = static_cast<PngInput*>(png_get_error_ptr(png));
  std::strncpy(input->message, text, sizeof(input->message) - 1);
  png_longjmp(png, 1);
}

void on_png_warning(png_structp, png_const_charp) {}

void read_png_bytes(png_structp png, png_bytep out, png_size_t count) {
  auto* input = static_cast<PngInput*>(png_get_io_ptr(png));
  if (count > input->bytes.size() - input->at) png_error(png, "the file ends too soon");
  std::memcpy(out, input->bytes.data() + input->at, count);
  input->at += count;
}

// libpng's state while a picture is read.
class PngReading {
 public:
  explicit PngReading(PngInput& input) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input, on_png_error, on_png_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw Error(ErrorCode::kOutOfMemory, "libpng: no memory for its state");
  }
  ~PngReading() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReading(const PngReading&) = delete;
  PngReading& operator=(const PngReading&) = delete;

  png_structp png() const noexcept { return png_; }
  png_infop info() const noexcept { return info_; }

 private:
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

// Between setjmp and a longjmp: no object with a destructor lives in these two.
bool begin_png(png_structp png, png_infop info, PngInput* input) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, input, read_png_bytes);
  png_read_info(png, info);
  png_set_expand(png);
  png_set_strip_alpha(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return true;
}

bool read_png_rows(png_structp png, png_bytep* rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

[[noreturn]] void refuse_png(const PngInput& input) {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: cannot be read: libpng: {}", input.name, input.message));
}

SliceShape begun_shape(const PngReading& reading) {
  SliceShape shape;
  shape.width = png_get_image_width(reading.png(), reading.info());
  shape.height = png_get_image_height(reading.png(), reading.info());
  shape.type = png_get_bit_depth(reading.png(), reading.info()) == 16 ? ScalarType::kUInt16
                                                                      : ScalarType::kUInt8;
  shape.num_components = png_get_channels(reading.png(), reading.info());
  return shape;
}

// What stands before the pixels is short, but for a profile of colours or a text.
constexpr std::int64_t kPngHeads[] = {std::int64_t{16} << 10, std::int64_t{8} << 20};

SliceShape shape_of_png(const ByteSource& source) {
  for (const std::int64_t size : kPngHeads) {
    PngInput input{source.text(0, size), 0, source.name()};
    const PngReading reading(input);
    if (begin_png(reading.png(), reading.info(), &input)) return begun_shape(reading);
    if (size >= source.size() || size == kPngHeads[1]) refuse_png(input);
  }
  return {};
}

void read_png_slice(const ByteSource& source, const SliceShape& shape, std::span<std::byte> out) {
  PngInput input{source.text(0, source.size()), 0, source.name()};
  const PngReading reading(input);
  if (!begin_png(reading.png(), reading.info(), &input)) refuse_png(input);
  const SliceShape found = begun_shape(reading);
  const std::size_t row_size = png_get_rowbytes(reading.png(), reading.info());
  if (found.num_bytes() != shape.num_bytes() || found.height != shape.height ||
      row_size * static_cast<std::size_t>(found.height) != out.size()) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has changed", source.name()));
  }
  std::vector<png_bytep> rows;
  for (std::size_t at = 0; at < out.size(); at += row_size)
    rows.push_back(reinterpret_cast<png_bytep>(out.data() + at));
  if (!read_png_rows(reading.png(), rows.data())) refuse_png(input);
}

}  // namespace

SliceReader png_slices() noexcept { return {"PNG", shape_of_png, read_png_slice}; }

}  // namespace ovoid::io
