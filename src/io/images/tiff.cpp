// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <optional>
#include <set>
#include <utility>

#include "data/bookkeeping.h"
#include "data/parallel.h"
#include "io/core/axis_order.h"
#include "io/core/chunked_array.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/core/unpacked_samples.h"
#include "io/images/tiff_blocks.h"
#include "io/images/tiff_description.h"
#include "io/images/tiff_file.h"
#include "io/images/tiff_shaped.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// The file's own lengths of a pixel, as it means lengths in the world by them: in centimetres.
// Inches are those of printers and screens.
std::optional<std::array<double, 2>> pixel_size_mm(const TiffFile& file) {
  constexpr int kCentimetre = 3;
  const auto& resolution = file.resolution();
  if (!resolution || resolution->unit != kCentimetre) return std::nullopt;
  return std::array{10 / resolution->x, 10 / resolution->y};
}

class TiffVolume {
 public:
  TiffVolume(const ByteSource& source, const ReadOptions& options)
      : source_(source), options_(options), file_(source) {}

  Dataset read() {
    dataset_.source = source_.name();
    dataset_.format = "TIFF";
    choose_stack();
    for (const std::string& what : stack_.notes) note(what);
    const bool is_in_order = options_.raw.axis_order.empty() && stack_.order.empty();
    if (!is_in_order) {
      read_in_order();
    } else {
      check_planes();
      const TiffPage& page = file_.pages()[0];
      dataset_.lattice.dims = {page.width, page.height, stack_.num_slices};
      dataset_.num_steps = stack_.num_frames;
      check_num_steps(source_.name() + ": frames", stack_.num_frames);
    }
    if (stack_.frame_interval) {
      for (std::int64_t step = 0; step < dataset_.num_steps; ++step)
        dataset_.times.push_back(static_cast<double>(step) * *stack_.frame_interval);
      dataset_.time_unit = stack_.time_unit;
    }
    place();
    tell();
    if (is_in_order) read_arrays();
    for (DataArray& array : dataset_.arrays) {
      if (is_in_order) widen_short_floats(file_.pages()[0].short_float, array);
      array.value_scale = stack_.value_scale;
      array.value_offset = stack_.value_offset;
      array.unit = stack_.value_unit;
    }
    return std::move(dataset_);
  }

 private:
  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", source_.name(), what));
  }

  void choose_stack() {
    const auto num_pages = static_cast<std::int64_t>(file_.pages().size());
    if (looks_like_ome(file_.description())) {
      std::vector<TiffStack> stacks = ome_stacks(source_.name(), file_.description());
      stack_ = std::move(stacks[choose_image(stacks)]);
      if (stacks.size() == 1) take_pages_that_are_there();
      return;
    }
    if (auto stack = imagej_stack(file_)) {
      stack_ = std::move(*stack);
      take_run();
      return;
    }
    if (std::vector<TiffStack> stacks = shaped_stacks(file_); !stacks.empty()) {
      stack_ = std::move(stacks[choose_image(stacks)]);
      take_run();
      return;
    }
    stack_.num_slices = num_pages;
    if (const auto size = pixel_size_mm(file_)) {
      stack_.spacing = {(*size)[0], (*size)[1], std::nullopt};
      stack_.length_unit = "mm";
    }
    constexpr std::uint16_t kMetaMorphPlanes = 33629;  // a value for each plane
    const std::uint64_t num_planes = file_.num_values(kMetaMorphPlanes);
    if (num_pages == 1 && num_planes > 1 && num_planes <= kMaxTiffPages) {
      stack_.num_slices = static_cast<std::int64_t>(num_planes);
      take_run();
    }
    if (const std::string program = unread_tiff_program(file_); !program.empty()) {
      note(
          fmt::format("was written by {}, whose own description is not read: pages are slices; "
                      "Fiji makes an OME-TIFF of it",
                      program));
    }
  }

  // One directory may stand for planes behind each other. A description that was copied to a file
  // of one plane does not make it more.
  void take_run() {
    if (file_.pages().size() != 1 || stack_.num_planes() == 1) return;
    run_ = file_.run(stack_.num_planes());
    const auto end_of = [&](std::int64_t num_planes) {
      return run_->offset + num_planes * file_.pages()[0].num_bytes();
    };
    if (run_ && end_of(2) <= source_.size()) {
      const std::int64_t end = end_of(stack_.num_planes());
      // Of a file that is cut short the error tells how many planes there should be.
      if (end > source_.size() || !file_.is_described_within(run_->offset, end)) return;
    }
    run_.reset();
    stack_.notes.push_back(
        fmt::format("its description names {} slices, {} channels and {} time steps, and it has "
                    "one page, which is read",
                    stack_.num_slices, stack_.num_channels, stack_.num_frames));
    stack_.num_slices = stack_.num_channels = stack_.num_frames = 1;
    stack_.channels.clear();
    stack_.order.clear();
    stack_.shape.clear();
  }

  // Of pages that follow each other in the order of the description there may be too few: of steps
  // those are taken that are whole.
  void take_pages_that_are_there() {
    const auto num_pages = static_cast<std::int64_t>(file_.pages().size());
    if (!stack_.directories.empty() || stack_.first + stack_.num_planes() <= num_pages) return;
    const std::int64_t num_planes = stack_.num_planes();
    const std::int64_t in_frame = stack_.num_slices * stack_.num_channels;
    const bool are_frames_last = stack_.num_frames > 1 && stack_.strides[2] == in_frame;
    if (are_frames_last && num_pages >= in_frame) {
      stack_.num_frames = num_pages / in_frame;
    } else {
      stack_.num_slices = num_pages;
      stack_.num_channels = stack_.num_frames = 1;
      stack_.strides = {1, 0, 0};
      stack_.channels.clear();
    }
    note(fmt::format(
        "its description names {} planes, and it has {} pages: these are read, as {} "
        "slices, {} channels and {} time steps",
        num_planes, num_pages, stack_.num_slices, stack_.num_channels, stack_.num_frames));
  }

  // Axes in another order, or the one that is asked for. Chunks are pages.
  void read_in_order() {
    const TiffPage& page = file_.pages()[0];
    ChunkedArray array;
    array.where = source_.name();
    array.axes = stack_.order;
    array.shape = stack_.shape;
    if (array.shape.empty()) {
      array.shape = {stack_.num_planes(), page.height, page.width};
      if (page.num_components > 1) array.shape.push_back(page.num_components);
    }
    if (!options_.raw.axis_order.empty()) {
      array.axes = options_.raw.axis_order;
      check_axis_order(source_.name(), array.axes, array.shape);
    }
    const std::size_t num_in_page = page.num_components > 1 ? 3 : 2;
    array.chunk = array.shape;
    std::fill(array.chunk.begin(), array.chunk.end() - static_cast<std::ptrdiff_t>(num_in_page), 1);
    array.type = page.type;
    array.short_float = page.short_float;
    array.is_big_endian = std::endian::native == std::endian::big;
    array.channels = stack_.channels;
    check_chunked(array);
    check_file_holds(checked_num_bytes(source_.name() + ": size", array.shape, page.type));
    array.read = [this, shape = array.shape, num_in_page](std::span<const std::int64_t> number,
                                                          std::span<std::byte> out) {
      std::int64_t plane = 0;
      for (std::size_t a = 0; a + num_in_page < shape.size(); ++a)
        plane = plane * shape[a] + number[a];
      read_plane(stack_.first + plane, out);
      return true;
    };
    ReadOptions options = options_;
    options.may_stay_in_file = false;  // the pages are this reader's
    read_chunked({array}, options, dataset_);
  }

  std::size_t choose_image(const std::vector<TiffStack>& stacks) {
    if (stacks.size() == 1) return 0;
    std::set<std::string> names;
    for (const TiffStack& stack : stacks) {
      // Names that stand twice get a number.
      std::string name = stack.name;
      for (int i = 2; !names.insert(name).second; ++i) name = fmt::format("{} {}", stack.name, i);
      dataset_.blocks.push_back(
          {name, fmt::format("{} slices, {} channels, {} time steps", stack.num_slices,
                             stack.num_channels, stack.num_frames)});
    }
    auto chosen =
        static_cast<std::size_t>(std::max_element(stacks.begin(), stacks.end(),
                                                  [](const TiffStack& a, const TiffStack& b) {
                                                    return a.num_planes() < b.num_planes();
                                                  }) -
                                 stacks.begin());
    if (!options_.block.empty()) {
      const auto named =
          std::find_if(dataset_.blocks.begin(), dataset_.blocks.end(),
                       [&](const DatasetBlock& block) { return block.name == options_.block; });
      if (named == dataset_.blocks.end()) {
        std::string known;
        for (const DatasetBlock& block : dataset_.blocks) known += fmt::format(" '{}'", block.name);
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: block '{}': no such image: expected one of{}", source_.name(),
                                options_.block, known));
      }
      chosen = static_cast<std::size_t>(named - dataset_.blocks.begin());
    } else {
      dataset_.notes.push_back(fmt::format("{}: holds {} images, '{}' is read; choose with --block",
                                           source_.name(), stacks.size(),
                                           dataset_.blocks[chosen].name));
    }
    dataset_.block = dataset_.blocks[chosen].name;
    return chosen;
  }

  // Pages of planes: by what the description says, or in their order. All must be there.
  void check_planes() {
    if (run_) return;
    const auto num_pages = static_cast<std::int64_t>(file_.pages().size());
    const std::int64_t last = stack_.first + stack_.num_planes();
    const std::int64_t num_missing =
        stack_.directories.empty()
            ? std::max<std::int64_t>(0, last - num_pages)
            : std::count(stack_.directories.begin(), stack_.directories.end(), -1);
    if (num_missing > 0) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: has {} pages, its description names {} slices, {} channels and {} "
                      "time steps: {} planes are missing",
                      source_.name(), num_pages, stack_.num_slices, stack_.num_channels,
                      stack_.num_frames, num_missing));
    }
  }

  void place() {
    Vec3 spacing(1, 1, 1);
    const auto& told = stack_.spacing;
    if (options_.raw.spacing) {
      spacing = *options_.raw.spacing;
    } else if (told[0] || told[1] || told[2]) {
      const double pixel = told[0].value_or(told[1].value_or(1));
      spacing = {pixel, told[1].value_or(pixel), told[2].value_or(pixel)};
      if (!told[2] && dataset_.lattice.dims[2] > 1) {
        note(
            fmt::format("the distance of slices is not said: taken to be that of pixels, {:g}; "
                        "--spacing says another",
                        spacing.z()));
      }
      if (!stack_.length_unit.empty() && stack_.length_unit != "mm")
        note(fmt::format("lengths are in {}, as the file has them", stack_.length_unit));
    }
    dataset_.lattice.world_from_index.linear() = spacing.asDiagonal();
    check_geometry(options_.raw.spacing ? "spacing" : source_.name() + ": size of pixels",
                   dataset_.lattice.world_from_index);
  }

  void tell() {
    const TiffPage& page = file_.pages()[0];
    if (file_.num_left_out() > 0) {
      note(fmt::format("{} pages in miniature or of lower resolution are left out",
                       file_.num_left_out()));
    }
    if (page.is_white_zero) note("says that 0 is white: values are those that it stores");
    if (page.num_components < page.num_samples) note("transparency is left out");
    if (page.is_palette) note("has a palette: values are its numbers");
    if (page.short_float != ShortFloat::kNone)
      note(fmt::format("{} becomes float32", name_of(page.short_float)));
  }

  void read_arrays() {
    if (options_.step) check_step(source_.name(), *options_.step, stack_.num_frames);
    if (read_in_a_row()) return;
    for (std::int64_t step = options_.step.value_or(0); step < stack_.num_frames; ++step) {
      read_frame(step);
      if (options_.step || data::is_worth_showing(dataset_, options_.array)) break;
      if (step + 1 == stack_.num_frames && step > 0) read_frame(0);  // none varies
    }
    if (!options_.step && dataset_.step > 0)
      dataset_.notes.push_back(chosen_step_note(source_.name(), dataset_.step, stack_.num_frames));
  }

  // Like raw data: what is read of these may stay in the file.
  bool read_in_a_row() {
    if (stack_.num_channels != 1 || stack_.first != 0 || !stack_.directories.empty()) return false;
    const bool is_step_by_step = stack_.strides[0] == 1 || stack_.num_slices == 1;
    if (!is_step_by_step && stack_.num_frames > 1) return false;
    if (!run_) run_ = file_.run(stack_.num_planes());
    if (!run_ || run_->num_pages != stack_.num_planes()) return false;
    const TiffPage& page = file_.pages()[0];
    StepLayout layout;
    layout.num_steps = stack_.num_frames;
    layout.type = page.type;
    layout.num_components = page.num_components;
    layout.is_big_endian = file_.is_big_endian();
    const std::array sizes{page.width, page.height, stack_.num_slices, stack_.num_frames};
    const std::int64_t num_bytes =
        checked_num_bytes(source_.name() + ": size", sizes, page.type, page.num_components);
    layout.num_bytes = num_bytes / stack_.num_frames;
    SampleParts parts;
    parts.each = {num_bytes, 0, page.type, source_.name(),
                  layout_text(sizes, page.type, page.num_components)};
    parts.open = [this](std::int64_t) {
      SamplePart part;
      part.source = &source_;
      part.offset = run_->offset;
      return part;
    };
    StepSamples samples = read_step(parts, layout, options_, dataset_.notes);
    dataset_.step = samples.step;
    dataset_.arrays.push_back({array_name(0), page.type, page.num_components,
                               num_samples(dataset_.lattice.dims), "", false, samples.bytes});
    dataset_.arrays.back().stored = std::move(samples.stored);
    return true;
  }

  std::string array_name(std::int64_t channel) const {
    const auto index = static_cast<std::size_t>(channel);
    std::string number =
        stack_.num_channels == 1 ? "values" : fmt::format("channel {}", channel + 1);
    if (stack_.channels.empty() || stack_.channels[index].name.empty()) return number;
    return name_among(stack_.channels, index, number);
  }

  void read_frame(std::int64_t frame) {
    dataset_.arrays.clear();
    dataset_.step = frame;
    std::vector<std::int64_t> channels;
    for (std::int64_t channel = 0; channel < stack_.num_channels; ++channel)
      if (options_.array.empty() || options_.array == array_name(channel))
        channels.push_back(channel);
    if (channels.empty()) {
      std::string known;
      for (std::int64_t channel = 0; channel < stack_.num_channels; ++channel)
        known += fmt::format(" '{}'", array_name(channel));
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: array '{}': no such channel: expected one of{}", source_.name(),
                              options_.array, known));
    }
    const TiffPage& page = file_.pages()[0];
    const std::array sizes{page.width, page.height, stack_.num_slices,
                           static_cast<std::int64_t>(channels.size())};
    const std::int64_t total =
        checked_num_bytes(source_.name() + ": size", sizes, page.type, page.num_components);
    check_file_holds(total);
    const bool is_chosen = options_.step || stack_.num_frames == 1;
    const bool are_in_file =
        is_chosen && page.num_components == 1 && stays_in_file(page.type, total, options_);
    ReadProgress progress(options_, total);
    for (const std::int64_t channel : channels) {
      DataArray array{array_name(channel),
                      page.type,
                      page.num_components,
                      num_samples(dataset_.lattice.dims),
                      "",
                      false,
                      {}};
      if (!stack_.channels.empty())
        array.display = stack_.channels[static_cast<std::size_t>(channel)].display;
      UnpackedSamples samples(source_.name(), page.num_bytes() * stack_.num_slices, are_in_file);
      read_planes(channel, frame, progress, &samples);
      samples.release(options_, &array);
      dataset_.arrays.push_back(std::move(array));
    }
  }

  // A header may claim more than all its bytes can stand for.
  void check_file_holds(std::int64_t total) const {
    const TiffPage& page = file_.pages()[0];
    const std::int64_t spread = page.bits < 8 ? 8 / page.bits : page.bits < 16 ? 2 : 1;
    if (total / spread / max_tiff_ratio(page.compression) <= source_.size()) return;
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has {} bytes, too few for {}", source_.name(), source_.size(),
                            layout_text(std::array{page.width, page.height, stack_.num_slices},
                                        page.type, page.num_components)));
  }

  void read_planes(std::int64_t channel, std::int64_t frame, ReadProgress& progress,
                   UnpackedSamples* samples) const {
    const std::int64_t page_bytes = file_.pages()[0].num_bytes();
    samples->make_room();
    // Unpacking takes longer than reading. Progress is told by this thread, after each batch.
    constexpr std::int64_t kBatch = 64;
    for (std::int64_t begin = 0; begin < stack_.num_slices; begin += kBatch) {
      data::ParallelPlan plan{.count = std::min(kBatch, stack_.num_slices - begin)};
      plan.threads = std::max(1, data::resolve_threads(0) / std::max(1, options_.processes_beside));
      data::parallel_ranges(plan, [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t z = begin + from; z < begin + to; ++z) {
          samples->put(z * page_bytes, page_bytes, [&](std::span<std::byte> place) {
            read_plane(stack_.page(z, channel, frame), place);
          });
        }
      });
      progress.advance(plan.count * page_bytes);
    }
  }

  void read_plane(std::int64_t number, std::span<std::byte> out) const {
    if (run_ && file_.pages().size() == 1) {  // ImageJ's own: one directory for all
      const std::int64_t at = run_->offset + number * static_cast<std::int64_t>(out.size());
      if (at > source_.size() - static_cast<std::int64_t>(out.size())) {
        throw Error(ErrorCode::kFileFormat,
                    fmt::format("{}: ends within plane {}", source_.name(), number));
      }
      source_.read(at, out);
      finish_tiff_rows(1, {out.size(), 0, 1, file_.pages()[0].bits, file_.is_big_endian()}, out);
      return;
    }
    const std::size_t index = stack_.directories.empty() ? static_cast<std::size_t>(number)
                                                         : file_.page_of_directory(number);
    file_.read(file_.pages()[index], out);
  }

  const ByteSource& source_;
  const ReadOptions& options_;
  TiffFile file_;
  TiffStack stack_;
  std::optional<TiffRun> run_;
  Dataset dataset_;
};

SliceShape shape_of_tiff(const ByteSource& source) {
  const TiffFile file(source);
  if (file.pages().size() > 1) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: has {} pages, a slice is one: name the files themselves, which are "
                    "then time steps",
                    source.name(), file.pages().size()));
  }
  const TiffPage& page = file.pages()[0];
  if (page.num_components != 1 && page.num_components != 3) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: has {} samples in each pixel: expected grey, or red, green and blue",
                    source.name(), page.num_components));
  }
  SliceShape shape{page.width, page.height, page.type, page.num_components, page.short_float};
  shape.spacing = pixel_size_mm(file);
  shape.length_unit = "mm";
  std::optional<TiffStack> stack = imagej_stack(file);
  if (!stack) {
    if (std::vector<TiffStack> stacks = shaped_stacks(file); !stacks.empty())
      stack = std::move(stacks[0]);
  }
  if (stack && stack->spacing[0] && stack->spacing[1]) {
    shape.spacing = std::array{*stack->spacing[0], *stack->spacing[1]};
    shape.length_unit = stack->length_unit;
  }
  return shape;
}

void read_tiff_slice(const ByteSource& source, const SliceShape& shape, std::span<std::byte> out) {
  const TiffFile file(source);
  const TiffPage& page = file.pages()[0];
  if (page.num_bytes() != static_cast<std::int64_t>(out.size()) || page.width != shape.width)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has changed", source.name()));
  file.read(page, out);
}

}  // namespace

Dataset read_tiff(const ByteSource& source, const ReadOptions& options) {
  return TiffVolume(source, options).read();
}

SliceReader tiff_slices() noexcept { return {"TIFF", shape_of_tiff, read_tiff_slice}; }

}  // namespace ovoid::io
