// SPDX-License-Identifier: Apache-2.0
// Films as animated GIF. The pictures are read twice: for the colours of all of them, and to be
// written, each when its turn comes. One palette for the whole film: with one for each frame, what
// stands still would flicker.
#include <fmt/format.h>
#include <gif_lib.h>

#include <cmath>
#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/pictures/palette.h"
#include "io/pictures/pictures.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

constexpr int kMostGifSide = 65535;  // 16 bits in the file

// giflib's errors as exceptions; those of writing, which must not cross it, are kept on the way.
class GifOutput {
 public:
  GifOutput(const std::string& path, const std::stop_token& stop) : path_(path), file_(path, stop) {
    int error = 0;
    gif_ = EGifOpen(
        this,
        [](GifFileType* gif, const GifByteType* bytes, int size) {
          return static_cast<GifOutput*>(gif->UserData)->write(bytes, size);
        },
        &error);
    if (gif_ == nullptr) fail(error);
    EGifSetGifVersion(gif_, true);  // 89a, which has extensions
  }
  ~GifOutput() {
    if (gif_ != nullptr) close();
  }
  GifOutput(const GifOutput&) = delete;
  GifOutput& operator=(const GifOutput&) = delete;

  void begin(int width, int height, const std::vector<io::Rgb8>& palette) {
    int num_colors = 2;
    while (num_colors < static_cast<int>(palette.size())) num_colors *= 2;
    const std::unique_ptr<ColorMapObject, decltype(&GifFreeMapObject)> colors(
        GifMakeMapObject(num_colors, nullptr), GifFreeMapObject);
    if (!colors) throw std::bad_alloc();
    for (std::size_t i = 0; i < palette.size(); ++i)
      colors->Colors[i] = {palette[i][0], palette[i][1], palette[i][2]};
    constexpr int kBitsOfColors = 8;
    check(EGifPutScreenDesc(gif_, width, height, kBitsOfColors, 0, colors.get()));
    // Without an end: 1, and how often in 16 bits, where 0 means for ever.
    const unsigned char loop[] = {1, 0, 0};
    check(EGifPutExtensionLeader(gif_, APPLICATION_EXT_FUNC_CODE));
    check(EGifPutExtensionBlock(gif_, 11, "NETSCAPE2.0"));
    check(EGifPutExtensionBlock(gif_, sizeof(loop), loop));
    check(EGifPutExtensionTrailer(gif_));
  }

  void begin_frame(int width, int height, int delay_cs, int clear_index) {
    GraphicsControlBlock control{};
    control.DelayTime = delay_cs;
    control.TransparentColor = clear_index;
    // Where the next frame is clear, this one must not be seen through it.
    control.DisposalMode =
        clear_index == NO_TRANSPARENT_COLOR ? DISPOSE_DO_NOT : DISPOSE_BACKGROUND;
    GifByteType bytes[4];
    EGifGCBToExtension(&control, bytes);
    check(EGifPutExtension(gif_, GRAPHICS_EXT_FUNC_CODE, sizeof(bytes), bytes));
    check(EGifPutImageDesc(gif_, 0, 0, width, height, false, nullptr));
  }

  void put_row(std::vector<std::uint8_t>& row) {
    check(EGifPutLine(gif_, row.data(), static_cast<int>(row.size())));
  }

  void commit() {
    check(close());
    file_.commit();
  }

 private:
  int write(const GifByteType* bytes, int size) noexcept {
    if (write_error_) return 0;
    try {
      file_.write(bytes, static_cast<std::size_t>(size));
      return size;
    } catch (...) {
      write_error_ = std::current_exception();
      return 0;
    }
  }

  // giflib does not look whether the last byte was written.
  int close() noexcept {
    int ignored = 0;
    const int done = EGifCloseFile(gif_, &ignored);
    gif_ = nullptr;
    return done;
  }

  void check(int done) {
    if (write_error_) std::rethrow_exception(write_error_);
    if (done != GIF_OK) fail(gif_ != nullptr ? gif_->Error : 0);
  }

  [[noreturn]] void fail(int error) const {
    const char* const reason = GifErrorString(error);
    throw Error(ErrorCode::kFileWrite, fmt::format("{}: cannot be written: giflib: {}", path_,
                                                   reason == nullptr ? "unknown error" : reason));
  }

  std::string path_;
  io::AtomicFile file_;
  std::exception_ptr write_error_;
  GifFileType* gif_ = nullptr;
};

io::Rgba8Picture read_frame(const std::string& path, const io::Rgba8Picture& first) {
  io::Rgba8Picture picture = io::read_png(path);
  const bool is_first = first.rgba.empty();
  if (is_first && (picture.width > kMostGifSide || picture.height > kMostGifSide)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: is {}x{}: a GIF has at most {} pixels a side", path, picture.width,
                            picture.height, kMostGifSide));
  }
  if (!is_first && (picture.width != first.width || picture.height != first.height)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: is {}x{}: expected {}x{}, as the first picture is", path,
                            picture.width, picture.height, first.width, first.height));
  }
  return picture;
}

void check_speed(double fps) {
  if (fps >= kMinGifFps && fps <= kMaxGifFps) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("fps = {}: expected {} to {} of a GIF", fps, kMinGifFps, kMaxGifFps));
}

// Hundredths of a second from the start to the end of a frame's time, each rounded: no frame is
// wrong by more than one, and the whole film by no more than a half.
int delay_of(std::size_t frame, double fps) {
  const auto end_of = [&](std::size_t number) {
    return std::llround(100 * static_cast<double>(number) / fps);
  };
  return static_cast<int>(end_of(frame + 1) - end_of(frame));
}

// How much of the film is done when so many pictures have been looked at, and so many written. To
// write one, to which it is read again, takes about twice as long as to look at it.
double share_done(std::size_t looked_at, std::size_t written, std::size_t num_pictures) {
  constexpr double kShareOfLooks = 1.0 / 3;
  return (kShareOfLooks * static_cast<double>(looked_at) +
          (1 - kShareOfLooks) * static_cast<double>(written)) /
         static_cast<double>(num_pictures);
}

void put_frame(GifOutput& gif, const io::Rgba8Picture& picture, int delay_cs, int clear_index,
               io::PaletteMatcher& matcher, const std::stop_token& stop) {
  gif.begin_frame(picture.width, picture.height, delay_cs, clear_index);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(picture.width));
  const std::uint8_t* pixel = picture.rgba.data();
  for (int y = 0; y < picture.height; ++y) {
    io::check_stop(stop);
    for (int x = 0; x < picture.width; ++x, pixel += 4) {
      row[static_cast<std::size_t>(x)] = pixel[3] < io::kLeastOpaque
                                             ? static_cast<std::uint8_t>(clear_index)
                                             : matcher.index({pixel[0], pixel[1], pixel[2]}, x, y);
    }
    gif.put_row(row);
  }
}

}  // namespace

void write_gif(const std::vector<std::string>& pictures, const std::string& path, double fps,
               const WriteOptions& options) try {
  if (pictures.empty())
    throw Error(ErrorCode::kInvalidArgument, "pictures: is empty: expected at least one");
  check_speed(fps);
  io::check_writable(path);
  std::size_t num_looked_at = 0;
  std::size_t num_written = 0;
  const auto tell = [&] {
    if (options.progress) options.progress(share_done(num_looked_at, num_written, pictures.size()));
  };
  io::Rgba8Picture first;
  std::vector<io::Rgb8> palette;
  int clear_index = NO_TRANSPARENT_COLOR;
  {
    io::ColorCounts counts;
    for (const std::string& name : pictures) {
      io::check_stop(options.stop);
      io::Rgba8Picture picture = read_frame(name, first);
      counts.add(picture.rgba);
      if (first.rgba.empty()) first = std::move(picture);
      ++num_looked_at;
      tell();
    }
    constexpr std::size_t kMostColors = 256;
    palette = counts.palette(kMostColors - (counts.has_clear() ? 1 : 0), options.stop);
    if (counts.has_clear()) clear_index = static_cast<int>(palette.size());
  }
  io::PaletteMatcher matcher(palette);
  if (clear_index != NO_TRANSPARENT_COLOR) palette.push_back({});
  GifOutput gif(path, options.stop);
  gif.begin(first.width, first.height, palette);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    put_frame(gif, read_frame(pictures[i], first), delay_of(i, fps), clear_index, matcher,
              options.stop);
    ++num_written;
    tell();
  }
  gif.commit();
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, path + ": no memory to write it");
}

}  // namespace ovoid
