// SPDX-License-Identifier: Apache-2.0
// Ovoid's HDF5 lattices, written: docs/formats.md says what stands where. The library writes here;
// only on reading does it meet bytes that are not ours.
#include "ovoid/lattice_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "data/lattice/encode_relevant.h"
#include "data/lattice/stored_number.h"
#include "data/scalar_visit.h"
#include "io/cell_lattice.h"
#include "io/core/atomic_file.h"
#include "io/core/samples.h"
#include "io/hdf5/hdf5_lattice_format.h"
#include "io/hdf5/hdf5_writer.h"
#include "io/hdf5/stored_boxes.h"
#include "io/hdf5/stored_level.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::kInvalidArgument, what); }

}  // namespace

LatticeFileHeader lattice_file_header(const Dataset& dataset) {
  if (dataset.kind != DatasetKind::kLattice) {
    throw Error(ErrorCode::kUnsupported, fmt::format("a lattice file holds a lattice, the dataset "
                                                     "is {}",
                                                     name_of(dataset.kind)));
  }
  if (dataset.arrays.empty()) fail("the dataset has no array to write");
  LatticeFileHeader header;
  const DataArray& first = dataset.arrays[0];
  header.lattice = io::lattice_of(dataset.lattice, first);
  header.space = dataset.space;
  for (const DataArray& array : dataset.arrays) {
    if (array.is_cell_data != first.is_cell_data) {
      fail(
          fmt::format("arrays '{}' and '{}': one has its samples in the cells: a lattice file "
                      "holds arrays of one lattice, choose some",
                      first.name, array.name));
    }
    header.arrays.push_back({array.name, array.type, array.num_components, array.unit,
                             array.value_scale, array.value_offset});
  }
  const auto step = static_cast<std::size_t>(dataset.step);
  if (dataset.step >= 0 && step < dataset.times.size()) {
    header.times = {dataset.times[step]};
    header.time_unit = dataset.time_unit;
  }
  return header;
}

LatticeFileHeader lattice_file_header(const Dataset& dataset, const std::string& array,
                                      LatticeContent content, bool whole) {
  Dataset one = dataset;
  one.arrays = {dataset.array(array)};
  LatticeFileHeader header = lattice_file_header(one);
  header.content = content;
  LatticeFileArray& stored = header.arrays[0];
  stored.num_components = 1;
  if (!whole) stored = {.name = stored.name, .unit = stored.unit};
  return header;
}

namespace {

using io::kChunkBytes;
// The library packs chunks of less than 4 GiB.
constexpr std::int64_t kMaxRowBytes = std::int64_t{1} << 30;

void check_text(const std::string& what, const std::string& text) {
  if (text.size() <= io::kMaxHdf5Text) return;
  fail(fmt::format("{}: has {} bytes: expected at most {}", what, text.size(), io::kMaxHdf5Text));
}

void check_relevant(const LatticeFileHeader& header) {
  const RelevantSamples& relevant = *header.relevant;
  if (!std::isfinite(relevant.above))
    fail(fmt::format("relevant.above = {}: must be finite", relevant.above));
  if (relevant.background && !std::isfinite(*relevant.background))
    fail(fmt::format("relevant.background = {}: must be finite", *relevant.background));
  for (const LatticeFileArray& array : header.arrays) {
    if (array.num_components != 1)
      fail(fmt::format("array '{}': has {} components: runs hold arrays of one", array.name,
                       array.num_components));
  }
}

const char* word_of(LatticeContent content) {
  return content == LatticeContent::kLevels  ? "levels"
         : content == LatticeContent::kBoxes ? "boxes"
                                             : "samples";
}

// Of levels and boxes.
void check_content(const LatticeFileHeader& header) {
  const char* const word = word_of(header.content);
  if (header.relevant) fail(fmt::format("relevant: samples are stored as runs or as {}", word));
  if (header.lattice.kind != LatticeKind::kCartesian || header.series == SeriesKind::kStaggered)
    fail(fmt::format("lattice: must be cartesian, {} hold no other", word));
  for (const LatticeFileArray& array : header.arrays) {
    if (!io::are_simple_samples(array.type) || array.num_components != 1) {
      fail(
          fmt::format("array '{}': is {} x {}: {} hold float32 and integers of 1 or 2 bytes, of "
                      "one component",
                      array.name, name_of(array.type), array.num_components, word));
    }
  }
}

void check_header(const LatticeFileHeader& header) {
  const LatticeGeometry& lattice = header.lattice;
  if (header.arrays.empty()) fail("arrays: there are none to write");
  if (header.series == SeriesKind::kStaggered && lattice.kind != LatticeKind::kCartesian)
    fail("lattice: must be cartesian in a staggered series");
  try {
    io::check_geometry("lattice", lattice.world_from_index);
    for (const LatticeFileArray& array : header.arrays)
      io::checked_num_bytes("lattice", lattice.dims, array.type, std::max(array.num_components, 1));
  } catch (const Error& error) {
    fail(error.what());
  }
  for (std::size_t i = 0; i < header.arrays.size(); ++i) {
    const LatticeFileArray& array = header.arrays[i];
    const std::string where = fmt::format("arrays[{}]", i);
    check_text(where + ".name", array.name);
    check_text(where + ".unit", array.unit);
    if (array.num_components < 1)
      fail(fmt::format("{}.num_components = {}: must be >= 1", where, array.num_components));
    if (!std::isfinite(array.value_scale) || array.value_scale == 0)
      fail(fmt::format("{}.value_scale = {}: must be finite and not 0", where, array.value_scale));
    if (!std::isfinite(array.value_offset))
      fail(fmt::format("{}.value_offset = {}: must be finite", where, array.value_offset));
    if (lattice.dims[0] >
        kMaxRowBytes / array.num_components / static_cast<std::int64_t>(size_of(array.type)))
      fail(fmt::format("{}: a row of {} samples has more than 1 GiB", where, lattice.dims[0]));
  }
  check_text("time_unit", header.time_unit);
  if (header.relevant) check_relevant(header);
  if (header.content != LatticeContent::kSamples) check_content(header);
  for (std::size_t i = 0; i < header.times.size(); ++i) {
    if (!std::isfinite(header.times[i]))
      fail(fmt::format("times[{}] = {}: must be finite", i, header.times[i]));
  }
  if (header.series == SeriesKind::kStaggered && !io::are_staggered_times(header.times))
    fail("times: must rise in equal distances in a staggered series");
}

}  // namespace

class LatticeFileWriter::Impl {
 public:
  Impl(const std::string& path, LatticeFileHeader header, std::stop_token stop)
      : path_(path), header_(std::move(header)), stop_(std::move(stop)) {
    check_header(header_);
    try {
      io::require_hdf5(0);
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("{}: {}", path, error.what()));
    }
    target_ = std::make_unique<io::AtomicFile>(path, stop_);
    file_ = io::make_hdf5_file(target_->partial_path());
    require(file_.is_open());
    write_header();
  }
  ~Impl() { close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const LatticeFileHeader& header() const noexcept { return header_; }
  std::int64_t num_steps() const noexcept { return num_steps_; }
  const LatticeFileCounts& counts() const noexcept { return counts_; }

  void write_levels(std::span<const LatticeLevels> levels) {
    write_content(LatticeContent::kLevels, levels,
                  [](const LatticeLevels& all) { return all.num_kernels(); });
  }

  void write_boxes(std::span<const LatticeBoxes> boxes) {
    write_content(LatticeContent::kBoxes, boxes, [](const LatticeBoxes& all) {
      return static_cast<std::int64_t>(all.boxes.size());
    });
  }

  void write_step(std::span<const Bytes> samples) {
    if (!file_.is_open()) fail("write_step: the file is finished");
    if (header_.content != LatticeContent::kSamples)
      fail(
          fmt::format("write_step: the header says that {} are written", word_of(header_.content)));
    if (samples.size() != header_.arrays.size())
      fail(fmt::format("samples: {} arrays: expected {}", samples.size(), header_.arrays.size()));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const std::size_t expected = static_cast<std::size_t>(num_bytes(header_.arrays[i]));
      if (samples[i].view.size() != expected) {
        fail(fmt::format("samples[{}]: {} bytes: expected {} for {}", i, samples[i].view.size(),
                         expected,
                         io::layout_text(header_.lattice.dims, header_.arrays[i].type,
                                         header_.arrays[i].num_components)));
      }
    }
    for (std::size_t i = 0; i < samples.size(); ++i) {
      counts_.num_samples += num_samples(header_.lattice.dims);
      counts_.dense_bytes += num_bytes(header_.arrays[i]);
      header_.relevant ? write_runs(groups_[i], header_.arrays[i], samples[i])
                       : write_dense(groups_[i], header_.arrays[i], samples[i].view.data());
    }
    if (!header_.relevant) counts_.num_relevant = counts_.num_samples;
    ++num_steps_;
  }

  void finish() {
    if (!file_.is_open()) fail("finish: the file is finished already");
    if (num_steps_ == 0) fail("finish: no step was written");
    const auto num_times = static_cast<std::int64_t>(header_.times.size());
    if (num_times != 0 && num_times != num_steps_)
      fail(fmt::format("times: there are {}: expected one for each of {} steps", num_times,
                       num_steps_));
    const auto* const word = std::find_if(
        io::kHdf5LatticeWords.begin(), io::kHdf5LatticeWords.end(),
        [&](const io::Hdf5LatticeWord& w) {
          return w.kind == header_.lattice.kind && w.series == header_.series &&
                 (w.has_steps == (num_steps_ > 1) || w.kind == LatticeKind::kBodyCentred ||
                  w.series == SeriesKind::kStaggered);
        });
    require(file_.add_text("lattice", word->word) && file_.add_number("num_steps", num_steps_));
    if (num_times > 0) write_times();
    require(file_.flush() && close());
    target_->commit();
  }

 private:
  void require(bool holds) const {
    if (!holds)
      throw Error(
          ErrorCode::kFileWrite,
          fmt::format("{}: cannot be written by the HDF5 library: is the disk full?", path_));
  }

  // True if the library wrote everything.
  bool close() noexcept {
    bool is_well = true;
    for (io::Hdf5Object& group : groups_) is_well = group.close() && is_well;
    return file_.close() && is_well;
  }

  std::int64_t num_bytes(const LatticeFileArray& array) const {
    return num_samples(header_.lattice.dims) * array.num_components *
           static_cast<std::int64_t>(size_of(array.type));
  }

  void write_header() {
    const LatticeGeometry& lattice = header_.lattice;
    double rows[12];
    for (int i = 0; i < 12; ++i) rows[i] = lattice.world_from_index(i / 4, i % 4);
    // The halves of a staggered series have the distance of the samples of a sublattice.
    const double unit_spacing =
        header_.series == SeriesKind::kStaggered ? std::sqrt(0.5) : lattice.unit_spacing();
    require(file_.add_text("format", io::kHdf5LatticeFormat) &&
            file_.add_number("version", io::kHdf5LatticeVersion) &&
            file_.add_numbers("dims", ScalarType::kInt64, lattice.dims.data(), {3}) &&
            file_.add_numbers("world_from_index", ScalarType::kFloat64, rows, {3, 4}) &&
            file_.add_number("unit_spacing", unit_spacing) &&
            file_.add_text("space", name_of(header_.space)) &&
            file_.add_number("num_arrays", static_cast<std::int64_t>(header_.arrays.size())));
    for (std::size_t i = 0; i < header_.arrays.size(); ++i) {
      const LatticeFileArray& array = header_.arrays[i];
      groups_.push_back(file_.make_group(fmt::format("array{}", i)));
      const io::Hdf5Object& group = groups_.back();
      require(group.is_open() && group.add_text("name", array.name) &&
              group.add_text("unit", array.unit) &&
              group.add_number("components", std::int64_t{array.num_components}) &&
              group.add_number("value_scale", array.value_scale) &&
              group.add_number("value_offset", array.value_offset) &&
              group.add_text("encoding", encoding()));
    }
  }

  const char* encoding() const {
    if (header_.content != LatticeContent::kSamples) return word_of(header_.content);
    return header_.relevant ? "runs" : "dense";
  }

  void check(const LatticeLevels& levels) const { samples_of(levels, 0, stop_); }
  void check(const LatticeBoxes& boxes) const { samples_of(boxes, stop_); }

  // What stands for a step of every array.
  template <class Content, class Count>
  void write_content(LatticeContent content, std::span<const Content> arrays, const Count& count) {
    const char* const word = word_of(content);
    if (!file_.is_open()) fail(fmt::format("write_{}: the file is finished", word));
    if (header_.content != content)
      fail(fmt::format("write_{}: the header says nothing of {}", word, word));
    if (arrays.size() != header_.arrays.size())
      fail(fmt::format("{}: {} arrays: expected {}", word, arrays.size(), header_.arrays.size()));
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      if (arrays[i].dims != header_.lattice.dims)
        fail(fmt::format("{}[{}]: of {} samples: expected {}", word, i,
                         fmt::join(arrays[i].dims, " x "), fmt::join(header_.lattice.dims, " x ")));
      const ScalarType type = header_.arrays[i].type;
      if (arrays[i].whole == is_floating(type))
        fail(fmt::format("{}[{}]: whole = {}: the array is {}", word, i, arrays[i].whole,
                         name_of(type)));
      check(arrays[i]);  // which checks them: what is written can be read
      const io::Hdf5Object step = groups_[i].make_group(fmt::format("step{}", num_steps_));
      require(step.is_open());
      put(step, type, arrays[i]);
      counts_.num_samples += num_samples(header_.lattice.dims);
      counts_.dense_bytes += num_bytes(header_.arrays[i]);
      counts_.num_relevant += count(arrays[i]);
    }
    ++num_steps_;
  }

  using Sizes = std::vector<std::uint64_t>;

  // A dataset, a chunk of the first axis at a time, between which it may be stopped.
  void write_dataset(const io::Hdf5Object& group, const std::string& name, ScalarType type,
                     const Sizes& dims, const Sizes& chunk, const void* values) const {
    std::size_t row_bytes = size_of(type);
    for (std::size_t i = 1; i < dims.size(); ++i) row_bytes *= dims[i];
    io::require_hdf5(std::min(chunk[0], dims[0]) * row_bytes);
    io::Hdf5Object dataset = group.make_dataset(name, type, dims, chunk);
    require(dataset.is_open());
    const auto* from = static_cast<const std::byte*>(values);
    for (std::uint64_t row = 0; row < dims[0]; row += chunk[0]) {
      io::check_stop(stop_);
      const std::uint64_t count = std::min(chunk[0], dims[0] - row);
      require(dataset.write_rows(row, count, type, from));
      from += count * row_bytes;
    }
    require(dataset.close());
  }

  // Whole layers, or of one layer whole rows.
  void write_dense(const io::Hdf5Object& group, const LatticeFileArray& array,
                   const std::byte* samples) const {
    const Index3& size = header_.lattice.dims;
    const std::int64_t row_bytes =
        size[0] * array.num_components * static_cast<std::int64_t>(size_of(array.type));
    const std::int64_t rows = std::clamp<std::int64_t>(kChunkBytes / row_bytes, 1, size[1]);
    const std::int64_t layers =
        rows < size[1] ? 1 : std::clamp<std::int64_t>(kChunkBytes / (row_bytes * rows), 1, size[2]);
    const auto as_size = [](std::int64_t n) { return static_cast<std::uint64_t>(n); };
    Sizes dims{as_size(size[2]), as_size(size[1]), as_size(size[0])};
    Sizes chunk{as_size(layers), as_size(rows), as_size(size[0])};
    if (array.num_components > 1) {
      dims.push_back(static_cast<std::uint64_t>(array.num_components));
      chunk.push_back(dims.back());
    }
    write_dataset(group, fmt::format("step{}", num_steps_), array.type, dims, chunk, samples);
  }

  // A list in chunks of kChunkBytes; nothing if it is empty.
  void write_list(const io::Hdf5Object& group, const char* name, ScalarType type, std::size_t count,
                  const void* values) const {
    if (count == 0) return;
    write_dataset(group, name, type, {count},
                  {std::min<std::uint64_t>(count, kChunkBytes / size_of(type))}, values);
  }

  // As short numbers where rows are short enough.
  void write_list(const io::Hdf5Object& group, const char* name,
                  const std::vector<std::uint32_t>& numbers) const {
    if (header_.lattice.dims[0] > std::numeric_limits<std::uint16_t>::max())
      return write_list(group, name, ScalarType::kUInt32, numbers.size(), numbers.data());
    const std::vector<std::uint16_t> narrow(numbers.begin(), numbers.end());
    write_list(group, name, ScalarType::kUInt16, narrow.size(), narrow.data());
  }

  void write_runs(const io::Hdf5Object& array_group, const LatticeFileArray& array,
                  const Bytes& samples) {
    const data::RelevantRuns runs =
        data::encode_relevant(header_.lattice, {array.type, array.value_scale, array.value_offset},
                              samples, *header_.relevant, {.stop = stop_});
    counts_.num_relevant += runs.num_relevant();
    counts_.num_runs += runs.num_runs();
    counts_.run_bytes += static_cast<std::int64_t>(runs.num_bytes());
    const io::Hdf5Object step = array_group.make_group(fmt::format("step{}", num_steps_));
    require(step.is_open() &&
            step.add_numbers("background", array.type, runs.background_bytes().data()) &&
            step.add_number("num_runs", runs.num_runs()) &&
            step.add_number("num_relevant", runs.num_relevant()));
    const data::RunLists lists = runs.lists();
    const Index3& size = header_.lattice.dims;
    const std::int64_t rows = std::clamp<std::int64_t>(kChunkBytes / 4 / size[1], 1, size[2]);
    const std::int64_t columns = std::min(size[1], kChunkBytes / 4);
    write_dataset(step, "row_runs", ScalarType::kUInt32,
                  {static_cast<std::uint64_t>(size[2]), static_cast<std::uint64_t>(size[1])},
                  {static_cast<std::uint64_t>(rows), static_cast<std::uint64_t>(columns)},
                  lists.row_runs.data());
    write_list(step, "starts", lists.starts);
    write_list(step, "lengths", lists.lengths);
    write_list(step, "values", array.type, static_cast<std::size_t>(runs.num_relevant()),
               runs.values().data());
  }

  void put(const io::Hdf5Object& step, ScalarType type, const LatticeLevels& levels) const {
    std::vector<std::int64_t> counts;
    for (const LatticeLevel& level : levels.levels)
      counts.push_back(static_cast<std::int64_t>(level.nodes.size()));
    require(step.add_number("offset", levels.offset) &&
            add_number_as(step, "least", type, levels.least) &&
            add_number_as(step, "greatest", type, levels.greatest) &&
            step.add_number("step", levels.step) &&
            step.add_number("num_levels", static_cast<std::int64_t>(counts.size())));
    if (!counts.empty()) {
      require(step.add_numbers("num_kernels", ScalarType::kInt64, counts.data(),
                               {static_cast<std::uint64_t>(counts.size())}));
    }
    for (std::size_t l = 0; l < levels.levels.size(); ++l) {
      const io::StoredLevel stored(levels.levels[l]);
      write_list(step, fmt::format("gaps{}", l), stored.gaps);
      write_list(step, fmt::format("weights{}", l), stored.weights);
    }
    if (levels.holes.empty()) return;
    require(step.add_number("num_holes", static_cast<std::int64_t>(levels.holes.size() / 2)));
    write_list(step, "holes", io::stored_holes(levels));
  }

  void put(const io::Hdf5Object& step, ScalarType type, const LatticeBoxes& boxes) const {
    require(add_number_as(step, "least", type, boxes.least) &&
            add_number_as(step, "greatest", type, boxes.greatest) &&
            add_number_as(step, "background", type, boxes.background) &&
            step.add_number("step", boxes.step) &&
            step.add_number("num_boxes", static_cast<std::int64_t>(boxes.boxes.size())));
    for (const io::BoxNumber& number : io::kBoxNumbers)
      write_list(step, number.name, io::list_of(boxes, number));
  }

  void write_list(const io::Hdf5Object& group, const std::string& name,
                  const io::ShortNumbers& numbers) const {
    write_list(group, name.c_str(), numbers.type, numbers.count(), numbers.bytes.data());
  }
  static bool add_number_as(const io::Hdf5Object& object, const char* name, ScalarType type,
                            double value) {
    return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
      const T number = data::stored_number<T>(value);
      return object.add_numbers(name, type, &number);
    });
  }

  void write_times() const {
    const std::uint64_t count = header_.times.size();
    io::Hdf5Object times = file_.make_dataset("times", ScalarType::kFloat64, {count},
                                              {std::min<std::uint64_t>(count, kChunkBytes / 8)});
    require(times.is_open() &&
            times.write_rows(0, count, ScalarType::kFloat64, header_.times.data()) &&
            times.add_text("unit", header_.time_unit) && times.close());
  }

  std::string path_;
  LatticeFileHeader header_;
  std::stop_token stop_;
  std::unique_ptr<io::AtomicFile> target_;
  io::Hdf5Object file_;
  std::vector<io::Hdf5Object> groups_;  // of the arrays
  std::int64_t num_steps_ = 0;
  LatticeFileCounts counts_;
};

LatticeFileWriter::LatticeFileWriter(const std::string& path, LatticeFileHeader header,
                                     const WriteOptions& options)
    : impl_(std::make_unique<Impl>(path, std::move(header), options.stop)) {}
LatticeFileWriter::~LatticeFileWriter() = default;
LatticeFileWriter::LatticeFileWriter(LatticeFileWriter&&) noexcept = default;
LatticeFileWriter& LatticeFileWriter::operator=(LatticeFileWriter&&) noexcept = default;

const LatticeFileHeader& LatticeFileWriter::header() const noexcept { return impl_->header(); }
std::int64_t LatticeFileWriter::num_steps() const noexcept { return impl_->num_steps(); }

const LatticeFileCounts& LatticeFileWriter::counts() const noexcept { return impl_->counts(); }

void LatticeFileWriter::write_step(std::span<const Bytes> samples) { impl_->write_step(samples); }

void LatticeFileWriter::write_levels(std::span<const LatticeLevels> levels) {
  impl_->write_levels(levels);
}

void LatticeFileWriter::write_boxes(std::span<const LatticeBoxes> boxes) {
  impl_->write_boxes(boxes);
}

void LatticeFileWriter::write_step(const Dataset& step) {
  const std::vector<LatticeFileArray>& arrays = header().arrays;
  if (step.arrays.size() != arrays.size())
    fail(fmt::format("step {}: has {} arrays: expected {}", num_steps(), step.arrays.size(),
                     arrays.size()));
  std::vector<Bytes> samples;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const DataArray& array = step.arrays[i];
    if (array.name != arrays[i].name || array.type != arrays[i].type ||
        array.num_components != arrays[i].num_components) {
      fail(fmt::format("step {}: arrays[{}] is '{}', {} x {}: expected '{}', {} x {}", num_steps(),
                       i, array.name, name_of(array.type), array.num_components, arrays[i].name,
                       name_of(arrays[i].type), arrays[i].num_components));
    }
    samples.push_back(array.bytes);
  }
  write_step(samples);
}

void LatticeFileWriter::finish() { impl_->finish(); }

}  // namespace ovoid
