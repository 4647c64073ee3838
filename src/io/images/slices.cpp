// SPDX-License-Identifier: Apache-2.0
#include "io/images/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>
#include <tuple>
#include <utility>

#include "data/parallel.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/core/signatures.h"
#include "io/core/unpacked_samples.h"
#include "io/dicom/dicom.h"
#include "io/images/slice_names.h"
#include "io/images/slice_pictures.h"
#include "io/images/tiff_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostSlices = 100'000;
constexpr std::int64_t kPictureMagic = kDicomStart;  // bytes that tell a picture

SliceReader reader_of(const ByteSource& source) {
  const std::string format = picture_format_of(source.text(0, kPictureMagic));
  if (const auto reader = slice_reader(format)) return *reader;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: is {}: expected another slice, a picture of PNG, JPEG or TIFF",
                  source.name(), format.empty() ? "no picture" : "a " + format + " picture"));
}

std::string shape_text(const SliceShape& shape) {
  return fmt::format("{} x {} pixels of {}", shape.width, shape.height,
                     stored_name(shape.type, shape.short_float));
}

// Grey and colour may be mixed: programs that make files small store a grey picture's few greys as
// a palette.
bool fits(const SliceShape& a, const SliceShape& b) {
  return std::tie(a.width, a.height, a.type, a.short_float) ==
         std::tie(b.width, b.height, b.type, b.short_float);
}

// Throws for the first slice that is not as most are.
void check_shapes(const std::vector<std::string>& paths, const std::vector<SliceShape>& shapes) {
  const auto count_like = [&](const SliceShape& one) {
    return std::count_if(shapes.begin(), shapes.end(),
                         [&](const SliceShape& other) { return fits(one, other); });
  };
  const auto other = std::find_if(shapes.begin(), shapes.end(),
                                  [&](const SliceShape& shape) { return !fits(shape, shapes[0]); });
  if (other == shapes.end()) return;
  const auto place = [&](const SliceShape& shape) {
    return static_cast<std::size_t>(&shape - shapes.data());
  };
  const bool is_first_odd = count_like(*other) > count_like(shapes[0]);
  const SliceShape& odd = is_first_odd ? shapes[0] : *other;
  const SliceShape& usual = is_first_odd ? *other : shapes[0];
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: has {}, other slices, like {}, have {}: the slices of a volume are "
                          "of one size and type",
                          paths[place(odd)], shape_text(odd),
                          fs::path(paths[place(usual)]).filename().string(), shape_text(usual)));
}

// Of pixels in a row, each sample `size` bytes.
bool is_grey(std::span<const std::byte> rgb, std::size_t size) {
  for (std::size_t at = 0; at < rgb.size(); at += 3 * size)
    if (std::memcmp(&rgb[at], &rgb[at + size], 2 * size) != 0) return false;
  return true;
}

// Every pixel's first sample, to the front.
void keep_first_of_three(std::span<std::byte> rgb, std::size_t size) {
  for (std::size_t at = 0, to = 0; at < rgb.size(); at += 3 * size, to += size)
    std::memmove(&rgb[to], &rgb[at], size);
}

// Every sample three times; the grey ones stand at the end of `out`.
void spread_to_three(std::span<std::byte> out, std::size_t size) {
  std::size_t from = out.size() / 3 * 2;
  for (std::size_t at = 0; at < out.size(); from += size)
    for (int c = 0; c < 3; ++c, at += size) std::memmove(&out[at], &out[from], size);
}

class SliceVolume {
 public:
  SliceVolume(std::string source, const std::vector<std::string>& paths, const ReadOptions& options)
      : source_(std::move(source)), paths_(paths), options_(options) {}

  Dataset read() {
    look_at_all();
    Dataset dataset;
    dataset.source = source_;
    dataset.format = fmt::format("{} slices", format_);
    dataset.lattice.dims = {shapes_[0].width, shapes_[0].height,
                            static_cast<std::int64_t>(paths_.size())};
    place(dataset);
    DataArray array{"values", shapes_[0].type, 1, num_samples(dataset.lattice.dims), "", false, {}};
    take_samples(&array);
    widen_short_floats(shapes_[0].short_float, array);
    if (has_colours_) {
      dataset.notes.push_back(fmt::format(
          "{}: its slices are coloured: red, green and blue are three components", source_));
    }
    dataset.arrays.push_back(std::move(array));
    return dataset;
  }

 private:
  void look_at_all() {
    for (const std::string& path : paths_) {
      if (options_.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
      const auto source = open_file(path);
      const SliceReader reader = reader_of(*source);
      if (format_.empty()) format_ = reader.format;
      shapes_.push_back(reader.shape(*source));
      check_slice_size(*source, shapes_.back());
      has_colours_ = has_colours_ || shapes_.back().num_components == 3;
      num_file_bytes_ += source->size();
    }
    check_shapes(paths_, shapes_);
  }

  void place(Dataset& dataset) const {
    Vec3 spacing(1, 1, 1);
    if (options_.raw.spacing) {
      spacing = *options_.raw.spacing;
    } else if (const auto& pixels = shapes_[0].spacing) {
      spacing = {(*pixels)[0], (*pixels)[1], (*pixels)[0]};
      dataset.notes.push_back(
          fmt::format("{}: pixels are {:g} x {:g} {} large, as its files say; the distance of "
                      "slices is taken to be {:g}: --spacing says another",
                      source_, spacing.x(), spacing.y(), shapes_[0].length_unit, spacing.z()));
    }
    dataset.lattice.world_from_index.linear() = spacing.asDiagonal();
    check_geometry(options_.raw.spacing ? "spacing" : source_ + ": size of pixels",
                   dataset.lattice.world_from_index);
  }

  void take_samples(DataArray* array) {
    SliceShape whole = shapes_[0];
    whole.num_components = has_colours_ ? 3 : 1;
    const std::int64_t total = checked_num_bytes(
        source_ + ": size",
        std::array{whole.width, whole.height, static_cast<std::int64_t>(paths_.size())}, whole.type,
        whole.num_components);
    UnpackedSamples samples(source_, total,
                            !has_colours_ && stays_in_file(whole.type, total, options_));
    samples.make_room();
    // Unpacking takes longer than reading. Progress is told by this thread, after each batch.
    constexpr std::int64_t kBatch = 64;
    ReadProgress progress(options_, num_file_bytes_);
    const auto num_slices = static_cast<std::int64_t>(paths_.size());
    std::atomic<bool> is_coloured{false};
    for (std::int64_t begin = 0; begin < num_slices; begin += kBatch) {
      std::atomic<std::int64_t> num_read{0};
      data::ParallelPlan plan{.count = std::min(kBatch, num_slices - begin)};
      plan.threads = std::max(1, data::resolve_threads(0) / std::max(1, options_.processes_beside));
      data::parallel_ranges(plan, [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t i = begin + from; i < begin + to; ++i) {
          const auto source = open_file(paths_[static_cast<std::size_t>(i)]);
          samples.put(i * whole.num_bytes(), whole.num_bytes(), [&](std::span<std::byte> place) {
            if (read_one(*source, shapes_[static_cast<std::size_t>(i)], place)) is_coloured = true;
          });
          num_read += source->size();
        }
      });
      progress.advance(num_read);
    }
    if (has_colours_ && !is_coloured) {
      SampleBuffer& buffer = samples.memory();
      keep_first_of_three(buffer.bytes(), size_of(whole.type));
      buffer.shrink(buffer.size() / 3 * 2);
      has_colours_ = false;
    }
    array->num_components = has_colours_ ? 3 : 1;
    samples.release(options_, array);
  }

  // One slice to its place in the volume. Is a pixel of it coloured?
  static bool read_one(const ByteSource& source, const SliceShape& shape,
                       std::span<std::byte> out) {
    // Grey among colours is read to the end of its place, and spread from there.
    const auto num_bytes = static_cast<std::size_t>(shape.num_bytes());
    reader_of(source).read(source, shape, out.last(num_bytes));
    if (num_bytes < out.size()) spread_to_three(out, size_of(shape.type));
    return shape.num_components == 3 && !is_grey(out, size_of(shape.type));
  }

  std::string source_;
  const std::vector<std::string>& paths_;
  const ReadOptions& options_;
  std::string format_;  // of the first
  std::vector<SliceShape> shapes_;
  bool has_colours_ = false;
  std::int64_t num_file_bytes_ = 0;
};

bool is_picture_file(const std::string& path) {
  try {
    const auto source = open_file(path);
    return slice_reader(picture_format_of(source->text(0, kPictureMagic))).has_value();
  } catch (const Error&) {
    return false;
  }
}

Dataset read_slices(const std::string& source, SliceNames names, const ReadOptions& options) {
  Dataset dataset = SliceVolume(source, names.paths, options).read();
  dataset.notes.insert(dataset.notes.begin(), names.notes.begin(), names.notes.end());
  return dataset;
}

}  // namespace

bool is_slice_file(const std::string& path) {
  return is_picture_file(path) && !has_tiff_pages(*open_file(path));
}

std::vector<std::string> slice_files_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->path().filename().string().starts_with(".")) continue;
    if (!entry->is_regular_file(ignored) || !is_picture_file(entry->path().string())) continue;
    files.push_back(entry->path().string());
    if (files.size() > kMostSlices) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: holds more than {} pictures", folder, kMostSlices));
    }
  }
  if (error) {
    throw Error(ErrorCode::kFileNotFound,
                fmt::format("{}: cannot be read: {}", folder, error.message()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_slice_folder(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored) || slice_files_in(path).empty()) return false;
  const std::vector<std::string> files = dicom_files_in(path);
  return std::none_of(files.begin(), files.end(), is_dicom_file);
}

Dataset read_slice_folder(const std::string& folder, const ReadOptions& options) {
  return read_slices(folder, slices_of_folder(folder, slice_files_in(folder)), options);
}

Dataset read_slice_files(const std::vector<std::string>& paths, const ReadOptions& options) {
  const std::string source =
      paths.size() == 1 ? paths[0] : fmt::format("{} and {} more", paths[0], paths.size() - 1);
  return read_slices(source, slices_in_order(source, paths), options);
}

}  // namespace ovoid::io
