// SPDX-License-Identifier: Apache-2.0
// Ovoid's HDF5 lattices, written: docs/formats.md says what stands where. The library writes here;
// only on reading does it meet bytes that are not ours.
#include "ovoid/lattice_file.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "data/out_of_memory.h"
#include "io/atomic_file.h"
#include "io/cell_lattice.h"
#include "io/hdf5_lattice_format.h"
#include "io/samples.h"
#include "ovoid/error.h"

#ifdef OVOID_IO_HDF5
#include <limits>
#include <type_traits>

#include "data/encode_relevant.h"
#include "data/scalar_visit.h"
#include "io/hdf5_handle.h"
#include "io/hdf5_write_attributes.h"
#endif

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

#ifdef OVOID_IO_HDF5

namespace {

// Deflate at the level where, after shuffling, more effort buys next to nothing.
constexpr unsigned kDeflateLevel = 4;
// So much of a step is packed, and has to be unpacked, at once: a few layers.
constexpr std::int64_t kChunkBytes = std::int64_t{1} << 20;
// The library packs chunks of less than 4 GiB.
constexpr std::int64_t kMaxRowBytes = std::int64_t{1} << 30;

// Throws Error(kOutOfMemory) unless the library will find the memory that it needs: where it finds
// none it ends the process. It takes some MiB for itself, and with its filters three times a chunk.
void require_room(std::size_t chunk_bytes) {
  constexpr std::size_t kOwn = std::size_t{16} << 20;
  const std::size_t room = kOwn + 3 * chunk_bytes;
  // Not malloc(): what is freed unused need never have been there, to a compiler.
  void* const tried =
      ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (tried == MAP_FAILED) data::throw_out_of_memory("the HDF5 library", room);
  ::munmap(tried, room);
}

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
    require_room(0);
    const std::lock_guard lock(io::hdf5_mutex());
    const io::Hdf5Silence silence;
    target_ = std::make_unique<io::AtomicFile>(path, stop_);
    // The file format of HDF5 1.10, whose descriptions of things carry checksums: damage is told
    // before the library believes it.
    const io::Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    require(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_LATEST) >= 0);
    const io::Hdf5Handle plist(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    require(H5Pset_obj_track_times(plist.get(), 0) >= 0);
    file_ = {H5Fcreate(target_->partial_path().c_str(), H5F_ACC_TRUNC, plist.get(), access.get()),
             H5Fclose};
    require(file_.is_open());
    root_ = {H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose};
    require(root_.is_open());
    write_header();
  }
  ~Impl() {
    const std::lock_guard lock(io::hdf5_mutex());
    const io::Hdf5Silence silence;
    close();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const LatticeFileHeader& header() const noexcept { return header_; }
  std::int64_t num_steps() const noexcept { return num_steps_; }
  const LatticeFileCounts& counts() const noexcept { return counts_; }

  void write_step(std::span<const Bytes> samples) {
    if (!root_.is_open()) fail("write_step: the file is finished");
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
    const std::lock_guard lock(io::hdf5_mutex());
    const io::Hdf5Silence silence;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      counts_.num_samples += num_samples(header_.lattice.dims);
      counts_.dense_bytes += num_bytes(header_.arrays[i]);
      header_.relevant ? write_runs(groups_[i].get(), header_.arrays[i], samples[i])
                       : write_dense(groups_[i].get(), header_.arrays[i], samples[i].view.data());
    }
    if (!header_.relevant) counts_.num_relevant = counts_.num_samples;
    ++num_steps_;
  }

  void finish() {
    if (!root_.is_open()) fail("finish: the file is finished already");
    if (num_steps_ == 0) fail("finish: no step was written");
    const auto num_times = static_cast<std::int64_t>(header_.times.size());
    if (num_times != 0 && num_times != num_steps_)
      fail(fmt::format("times: there are {}: expected one for each of {} steps", num_times,
                       num_steps_));
    const std::lock_guard lock(io::hdf5_mutex());
    const io::Hdf5Silence silence;
    const auto* const word = std::find_if(
        io::kHdf5LatticeWords.begin(), io::kHdf5LatticeWords.end(),
        [&](const io::Hdf5LatticeWord& w) {
          return w.kind == header_.lattice.kind && w.series == header_.series &&
                 (w.has_steps == (num_steps_ > 1) || w.kind == LatticeKind::kBodyCentred ||
                  w.series == SeriesKind::kStaggered);
        });
    require(io::add_hdf5_text(root_.get(), "lattice", word->word) &&
            io::add_hdf5_number(root_.get(), "num_steps", num_steps_));
    if (num_times > 0) write_times();
    require(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) >= 0);
    require(close());
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
    for (io::Hdf5Handle& group : groups_) is_well = group.close() && is_well;
    is_well = root_.close() && is_well;
    return file_.close() && is_well;
  }

  std::int64_t num_bytes(const LatticeFileArray& array) const {
    return num_samples(header_.lattice.dims) * array.num_components *
           static_cast<std::int64_t>(size_of(array.type));
  }

  void write_header() {
    using io::add_hdf5_number, io::add_hdf5_numbers, io::add_hdf5_text;
    const hid_t root = root_.get();
    const LatticeGeometry& lattice = header_.lattice;
    double rows[12];
    for (int i = 0; i < 12; ++i) rows[i] = lattice.world_from_index(i / 4, i % 4);
    // The halves of a staggered series have the distance of the samples of a sublattice.
    const double unit_spacing =
        header_.series == SeriesKind::kStaggered ? std::sqrt(0.5) : lattice.unit_spacing();
    require(add_hdf5_text(root, "format", io::kHdf5LatticeFormat) &&
            add_hdf5_number(root, "version", io::kHdf5LatticeVersion) &&
            add_hdf5_numbers(root, "dims", ScalarType::kInt64, lattice.dims.data(), {3}) &&
            add_hdf5_numbers(root, "world_from_index", ScalarType::kFloat64, rows, {3, 4}) &&
            add_hdf5_number(root, "unit_spacing", unit_spacing) &&
            add_hdf5_text(root, "space", name_of(header_.space)) &&
            add_hdf5_number(root, "num_arrays", static_cast<std::int64_t>(header_.arrays.size())));
    const io::Hdf5Handle plist(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    require(H5Pset_obj_track_times(plist.get(), 0) >= 0);
    for (std::size_t i = 0; i < header_.arrays.size(); ++i) {
      const LatticeFileArray& array = header_.arrays[i];
      groups_.emplace_back(H5Gcreate2(root, fmt::format("array{}", i).c_str(), H5P_DEFAULT,
                                      plist.get(), H5P_DEFAULT),
                           H5Gclose);
      const hid_t group = groups_.back().get();
      require(groups_.back().is_open() && add_hdf5_text(group, "name", array.name) &&
              add_hdf5_text(group, "unit", array.unit) &&
              add_hdf5_number(group, "components", std::int64_t{array.num_components}) &&
              add_hdf5_number(group, "value_scale", array.value_scale) &&
              add_hdf5_number(group, "value_offset", array.value_offset) &&
              add_hdf5_text(group, "encoding", header_.relevant ? "runs" : "dense"));
    }
  }

  // A dataset, shuffled and deflated in chunks.
  void write_dataset(hid_t group, const std::string& name, ScalarType type,
                     const std::vector<hsize_t>& dims, const std::vector<hsize_t>& chunk,
                     const void* values) const {
    const io::Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    require(H5Pset_chunk(plist.get(), static_cast<int>(chunk.size()), chunk.data()) >= 0 &&
            H5Pset_shuffle(plist.get()) >= 0 && H5Pset_deflate(plist.get(), kDeflateLevel) >= 0 &&
            H5Pset_fill_time(plist.get(), H5D_FILL_TIME_NEVER) >= 0 &&
            H5Pset_obj_track_times(plist.get(), 0) >= 0);
    const io::Hdf5Handle space(
        H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose);
    require(space.is_open());
    io::Hdf5Handle dataset(H5Dcreate2(group, name.c_str(), io::hdf5_native(type), space.get(),
                                      H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                           H5Dclose);
    require(dataset.is_open());
    write_slabs(dataset.get(), type, dims, chunk[0], values);
    require(dataset.close());
  }

  // The values, a chunk of the first axis at a time, between which it may be stopped.
  void write_slabs(hid_t dataset, ScalarType type, const std::vector<hsize_t>& dims, hsize_t chunk,
                   const void* values) const {
    std::size_t row_bytes = size_of(type);
    for (std::size_t i = 1; i < dims.size(); ++i) row_bytes *= dims[i];
    require_room(std::min(chunk, dims[0]) * row_bytes);
    const auto* from = static_cast<const std::byte*>(values);
    std::vector<hsize_t> start(dims.size(), 0), count = dims;
    for (start[0] = 0; start[0] < dims[0]; start[0] += chunk) {
      io::check_stop(stop_);
      count[0] = std::min(chunk, dims[0] - start[0]);
      const int rank = static_cast<int>(dims.size());
      const io::Hdf5Handle memory(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
      const io::Hdf5Handle file(H5Dget_space(dataset), H5Sclose);
      require(memory.is_open() && file.is_open() &&
              H5Sselect_hyperslab(file.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                                  nullptr) >= 0 &&
              H5Dwrite(dataset, io::hdf5_native(type), memory.get(), file.get(), H5P_DEFAULT,
                       from) >= 0);
      from += count[0] * row_bytes;
    }
  }

  // Whole layers, or of one layer whole rows.
  void write_dense(hid_t group, const LatticeFileArray& array, const std::byte* samples) const {
    const Index3& size = header_.lattice.dims;
    const std::int64_t row_bytes =
        size[0] * array.num_components * static_cast<std::int64_t>(size_of(array.type));
    const std::int64_t rows = std::clamp<std::int64_t>(kChunkBytes / row_bytes, 1, size[1]);
    const std::int64_t layers =
        rows < size[1] ? 1 : std::clamp<std::int64_t>(kChunkBytes / (row_bytes * rows), 1, size[2]);
    const auto as_size = [](std::int64_t n) { return static_cast<hsize_t>(n); };
    std::vector<hsize_t> dims{as_size(size[2]), as_size(size[1]), as_size(size[0])};
    std::vector<hsize_t> chunk{as_size(layers), as_size(rows), as_size(size[0])};
    if (array.num_components > 1) {
      dims.push_back(static_cast<hsize_t>(array.num_components));
      chunk.push_back(dims.back());
    }
    write_dataset(group, fmt::format("step{}", num_steps_), array.type, dims, chunk, samples);
  }

  // A list in chunks of kChunkBytes; nothing if it is empty.
  void write_list(hid_t group, const char* name, ScalarType type, std::size_t count,
                  const void* values) const {
    if (count == 0) return;
    write_dataset(group, name, type, {count},
                  {std::min<hsize_t>(count, kChunkBytes / size_of(type))}, values);
  }

  // As short numbers where rows are short enough.
  void write_list(hid_t group, const char* name, const std::vector<std::uint32_t>& numbers) const {
    if (header_.lattice.dims[0] > std::numeric_limits<std::uint16_t>::max())
      return write_list(group, name, ScalarType::kUInt32, numbers.size(), numbers.data());
    const std::vector<std::uint16_t> narrow(numbers.begin(), numbers.end());
    write_list(group, name, ScalarType::kUInt16, narrow.size(), narrow.data());
  }

  void write_runs(hid_t array_group, const LatticeFileArray& array, const Bytes& samples) {
    const data::RelevantRuns runs =
        data::encode_relevant(header_.lattice, {array.type, array.value_scale, array.value_offset},
                              samples, *header_.relevant, {.stop = stop_});
    counts_.num_relevant += runs.num_relevant();
    counts_.num_runs += runs.num_runs();
    counts_.run_bytes += static_cast<std::int64_t>(runs.num_bytes());
    const io::Hdf5Handle plist(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    require(H5Pset_obj_track_times(plist.get(), 0) >= 0);
    const io::Hdf5Handle step(H5Gcreate2(array_group, fmt::format("step{}", num_steps_).c_str(),
                                         H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                              H5Gclose);
    require(step.is_open() &&
            io::add_hdf5_numbers(step.get(), "background", array.type,
                                 runs.background_bytes().data()) &&
            io::add_hdf5_number(step.get(), "num_runs", runs.num_runs()) &&
            io::add_hdf5_number(step.get(), "num_relevant", runs.num_relevant()));
    const data::RunLists lists = runs.lists();
    const Index3& size = header_.lattice.dims;
    const std::int64_t rows = std::clamp<std::int64_t>(kChunkBytes / 4 / size[1], 1, size[2]);
    const std::int64_t columns = std::min(size[1], kChunkBytes / 4);
    write_dataset(step.get(), "row_runs", ScalarType::kUInt32,
                  {static_cast<hsize_t>(size[2]), static_cast<hsize_t>(size[1])},
                  {static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)},
                  lists.row_runs.data());
    write_list(step.get(), "starts", lists.starts);
    write_list(step.get(), "lengths", lists.lengths);
    write_list(step.get(), "values", array.type, static_cast<std::size_t>(runs.num_relevant()),
               runs.values().data());
  }

  void write_times() const {
    const hsize_t count = header_.times.size();
    write_dataset(root_.get(), "times", ScalarType::kFloat64, {count},
                  {std::min<hsize_t>(count, kChunkBytes / 8)}, header_.times.data());
    const io::Hdf5Handle times(H5Dopen2(root_.get(), "times", H5P_DEFAULT), H5Dclose);
    require(times.is_open() && io::add_hdf5_text(times.get(), "unit", header_.time_unit));
  }

  std::string path_;
  LatticeFileHeader header_;
  std::stop_token stop_;
  std::unique_ptr<io::AtomicFile> target_;
  io::Hdf5Handle file_, root_;
  std::vector<io::Hdf5Handle> groups_;  // of the arrays
  std::int64_t num_steps_ = 0;
  LatticeFileCounts counts_;
};

#else

class LatticeFileWriter::Impl {
 public:
  Impl(const std::string& path, LatticeFileHeader, const std::stop_token&) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: this build has no HDF5 and cannot write .h5", path));
  }
  const LatticeFileHeader& header() const noexcept { return header_; }
  std::int64_t num_steps() const noexcept { return 0; }
  const LatticeFileCounts& counts() const noexcept { return counts_; }
  void write_step(std::span<const Bytes>) {}
  void finish() {}

 private:
  LatticeFileHeader header_;
  LatticeFileCounts counts_;
};

#endif

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
