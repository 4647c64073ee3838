// SPDX-License-Identifier: Apache-2.0
// One function for each family of readers: feeds it bytes as a hostile file would. What a reader
// may do is return something consistent or throw ovoid::Error; anything else ends in an exception
// of another type, a sanitizer's report or a crash. Called by the libFuzzer programs of this folder
// and by the mutation test among the unit tests.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "data/lattice/relevant_runs.h"
#include "io/core/byte_source.h"
#include "io/core/memory.h"
#include "io/core/signatures.h"
#include "io/dicom/dicom_codec.h"
#include "io/foreign/file_checks.h"
#include "io/foreign/gdcm_codec.h"
#include "io/foreign/vtk_header.h"
#include "io/images/slice_pictures.h"
#include "io/meshes/plot3d.h"
#include "io/read_source.h"
#include "io/reader/reader_session.h"
#include "io/vdb/vdb_header.h"
#include "ovoid/dataset.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::fuzz {

using Input = std::span<const std::byte>;

// Not derived from Error: says that a reader returned nonsense.
struct Inconsistent : std::logic_error {
  using std::logic_error::logic_error;
};

inline void require(bool holds, const char* what) {
  if (!holds) throw Inconsistent(what);
}

// What every caller of a reader relies on: an array has what it says.
inline void check_bytes(const DataArray& array, std::int64_t num_tuples) {
  require(array.num_components >= 1, "an array without components");
  require(array.num_tuples == num_tuples, "tuples that do not fit the dataset");
  const auto num_bytes = static_cast<std::uint64_t>(num_tuples) *
                         static_cast<std::uint64_t>(array.num_components) * size_of(array.type);
  require(array.bytes.view.size() == num_bytes, "bytes that do not fit the tuples");
  require(reinterpret_cast<std::uintptr_t>(array.bytes.view.data()) % size_of(array.type) == 0,
          "unaligned samples");
  // Every byte must be readable and, under a sanitizer that knows, initialised: it is for that one
  // to find, so the sum goes where no compiler leaves it out.
  unsigned sum = 0;
  for (const std::byte byte : array.bytes.view) sum += static_cast<unsigned>(byte);
  [[maybe_unused]] const volatile unsigned read_by_nobody = sum;
}

// Meshes, boxes and particles.
inline void check_points(const Dataset& dataset) {
  const std::int64_t num_points = dataset.num_positions();
  require(num_points >= 1, "no positions");
  check_bytes(dataset.positions, num_points);
  require(dataset.positions.num_components == 3 && is_floating(dataset.positions.type),
          "positions that are none");
  if (dataset.kind == DatasetKind::kBoxes) check_bytes(dataset.box_sizes, num_points);
  for (const DataArray& array : dataset.arrays)
    check_bytes(array, array.is_cell_data ? dataset.cells.count() : num_points);
  if (dataset.periodic_box) {
    require(
        dataset.periodic_box->sizes().minCoeff() > 0 && dataset.periodic_box->sizes().allFinite(),
        "a periodic box without volume");
  }
  require(
      dataset.times.empty() || static_cast<std::int64_t>(dataset.times.size()) == dataset.num_steps,
      "times that are not the steps'");
  const Cells& cells = dataset.cells;
  if (cells.is_structured()) {
    require(num_samples(cells.dims) == num_points, "dimensions that do not fit the nodes");
    return;
  }
  if (cells.types.empty()) return;
  require(cells.offsets.size() == cells.types.size() + 1 && cells.offsets.front() == 0 &&
              std::is_sorted(cells.offsets.begin(), cells.offsets.end()) &&
              cells.offsets.back() == static_cast<std::int64_t>(cells.connectivity.size()),
          "offsets that do not fit the cells");
  for (const std::uint32_t node : cells.connectivity)
    require(node < num_points, "a node that is not there");
}

// What every caller of a reader relies on.
inline void check_dataset(const Dataset& dataset) {
  if (dataset.kind != DatasetKind::kLattice) return check_points(dataset);
  const LatticeGeometry& lattice = dataset.lattice;
  for (const std::int64_t dim : lattice.dims) require(dim >= 1, "an axis without samples");
  require(lattice.world_from_index.matrix().allFinite(), "a geometry that is not finite");
  require(lattice.world_from_index.linear().determinant() != 0, "a degenerate geometry");
  require(!dataset.arrays.empty(), "no arrays");
  for (const DataArray& array : dataset.arrays) {
    std::int64_t num_tuples = 1;
    for (const std::int64_t dim : lattice.dims)
      num_tuples *= array.is_cell_data ? std::max<std::int64_t>(1, dim - 1) : dim;
    check_bytes(array, num_tuples);
  }
}

// Runs a reader; an Error is as good as a result.
template <typename Read>
void expect_dataset_or_error(const Read& read) {
  try {
    check_dataset(read());
  } catch (const Error& error) {
    require(std::string(error.what()).find('\n') == std::string::npos,
            "a message of several lines");
  }
}

// Detached data: every file that the header names has the input's own bytes, but for one that is
// missing.
inline void read_with_files(const std::string& name, Input input) {
  const io::Opener open = [input](const std::string& path) {
    if (path.ends_with("missing.raw"))
      throw Error(ErrorCode::kFileNotFound, "missing.raw: no such file");
    return io::open_memory(path, input);
  };
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory(name, input), {}, open); });
}

inline void nrrd(Input input) { read_with_files("fuzz.nhdr", input); }
inline void nifti(Input input) { read_with_files("fuzz.hdr", input); }
inline void metaimage(Input input) { read_with_files("fuzz.mhd", input); }

inline void slc(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.slc", input), {}); });
}

inline void npy(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.npy", input), {}); });
}

// A picture as a slice, in the format that its first bytes say.
inline void slice(Input input) {
  const auto source = io::open_memory("fuzz", input);
  const auto reader = io::slice_reader(io::picture_format_of(source->text(0, 16)));
  if (!reader) return;
  try {
    const io::SliceShape shape = reader->shape(*source);
    io::check_slice_size(*source, shape);
    constexpr std::int64_t kMost = std::int64_t{64} << 20;  // a picture of 64 KiB may be larger
    if (shape.num_bytes() > kMost) return;
    DataArray array{"slice", shape.type, shape.num_components, shape.width * shape.height, "",
                    false,   {}};
    const auto values = std::make_shared<std::vector<std::uint64_t>>((shape.num_bytes() + 7) / 8);
    const auto bytes = std::as_writable_bytes(std::span(*values))
                           .first(static_cast<std::size_t>(shape.num_bytes()));
    reader->read(*source, shape, bytes);
    array.bytes = {values, bytes};
    check_bytes(array, shape.width * shape.height);
  } catch (const Error& error) {
    require(std::string(error.what()).find('\n') == std::string::npos,
            "a message of several lines");
  }
}

inline void tiff(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.tif", input), {}); });
}

// A zip file of a Zarr hierarchy. What claims more memory than here is is refused.
inline void zarr(Input input) {
  struct LittleMemory {
    LittleMemory() { io::set_available_memory(std::int64_t{64} << 20); }
    ~LittleMemory() { io::set_available_memory(std::numeric_limits<std::int64_t>::max()); }
  } const little;
  const io::Opener open = [input](const std::string& path) { return io::open_memory(path, input); };
  const auto source = io::open_memory("fuzz.zip", input);
  expect_dataset_or_error([&] { return io::read_source(*source, {}, open); });
}

// Raw files have the input's own bytes. What claims more memory than here is is refused.
inline void xdmf(Input input) {
  struct SomeMemory {
    SomeMemory() { io::set_available_memory(std::int64_t{64} << 20); }
    ~SomeMemory() { io::set_available_memory(std::numeric_limits<std::int64_t>::max()); }
  } const some;
  read_with_files("fuzz.xmf", input);
}

inline void netcdf(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.nc", input), {}); });
}

inline void point_text(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.csv", input), {}); });
}

inline void npz(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.npz", input), {}); });
}

inline void ply(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.ply", input), {}); });
}

inline void lammps(Input input) {
  expect_dataset_or_error(
      [&] { return io::read_source(*io::open_memory("fuzz.dump", input), {}); });
}

// The input is a file's name; the file has 64 bytes.
inline void raw_name(Input input) {
  static constexpr std::byte kContent[64]{};
  const std::string name(reinterpret_cast<const char*>(input.data()), input.size());
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory(name, kContent), {}); });
}

inline void dicom(Input input) {
  expect_dataset_or_error([&] { return io::read_source(*io::open_memory("fuzz.dcm", input), {}); });
}

// The first byte chooses the transfer syntax, the rest is a stream for a frame of 23 x 17 samples.
inline void dicom_codec(Input input) {
  static constexpr const char* kSyntaxes[] = {"1.2.840.10008.1.2.5", "1.2.840.10008.1.2.4.70",
                                              "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.80",
                                              "1.2.840.10008.1.2.4.90"};
  if (input.empty()) return;
  io::use_gdcm();
  std::byte out[2 * 23 * 17];
  try {
    io::decode_dicom_frame(kSyntaxes[static_cast<unsigned>(input[0]) % std::size(kSyntaxes)],
                           input.subspan(1), {"fuzz", 23, 17, 16}, out);
  } catch (const Error&) {
    // Refused: as it should be.
  }
}

inline void vtk_header(Input input) {
  const auto source = io::open_memory("fuzz.vti", input);
  for (const bool is_xml : {true, false}) {
    try {
      is_xml ? io::check_vtk_xml(*source).grid : io::check_legacy_vtk(*source);
    } catch (const Error&) {
      // Refused: as it should be.
    }
  }
}

// A path under which `input` can be opened, for readers that know files only. It lives in memory.
class MemoryFile {
 public:
  explicit MemoryFile(Input input) : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    require(descriptor_ >= 0, "no memory file");
    require(::write(descriptor_, input.data(), input.size()) == static_cast<ssize_t>(input.size()),
            "memory file not written");
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

// A part of a picture, whose runs are read by OpenEXR.
inline void picture_part(Input input) {
  const MemoryFile file(input);
  try {
    const PicturePart part = read_picture_part(file.path());
    part.seen.validate();
    part.look.validate();
    require(1 <= part.number && part.number <= part.count, "a part of no picture");
  } catch (const Error& error) {
    require(std::string(error.what()).find('\n') == std::string::npos,
            "a message of several lines");
  }
}

inline void look_2d(Input input) {
  const MemoryFile file(input);
  try {
    const TransferFunction2D function = read_transfer_function_2d(file.path());
    const TransferFunction2D::Axis &values = function.values(), &gradients = function.gradients();
    require(values.first < values.last && 0 <= gradients.first && gradients.first < gradients.last,
            "an axis that does not rise");
    for (const double at : {values.first, 0.5 * (values.first + values.last), values.last}) {
      for (const double c : function.at(at, gradients.last))
        require(c >= 0 && c <= 1, "a component outside [0, 1]");
    }
  } catch (const Error& error) {
    require(std::string(error.what()).find('\n') == std::string::npos,
            "a message of several lines");
  }
}

inline void label_table(Input input) {
  const MemoryFile file(input);
  try {
    for (const LabelEntry& entry : read_label_table(file.path(), 1)) {
      if (entry.opacity)
        require(*entry.opacity >= 0 && *entry.opacity <= 1, "an opacity outside [0, 1]");
      for (const double c : entry.color.value_or(Rgb{}))
        require(c >= 0 && c <= 1, "a colour outside [0, 1]");
    }
  } catch (const Error& error) {
    require(std::string(error.what()).find('\n') == std::string::npos,
            "a message of several lines");
  }
}

inline void look(Input input) {
  const MemoryFile file(input);
  try {
    const Look look = read_look(file.path());
    look.validate();
    const TransferFunction& tf = look.transfer_function;
    const double lo = tf.lo(), hi = tf.hi();
    require(lo <= hi, "a transfer function that is not sorted");
    for (const double x : {lo, lo + (hi - lo) / 3, lo + (hi - lo) / 2, hi, -1.0, hi + 1.0}) {
      const double opacity = tf.opacity_at(x);
      require(opacity >= 0 && opacity <= 1, "an opacity outside [0, 1]");
      for (const double c : tf.color_at(x)) require(c >= 0 && c <= 1, "a colour outside [0, 1]");
    }
    TransferFunction moved = tf;
    if (lo < hi) moved.map_range(1.0, 1000.0);
    require(std::is_sorted(moved.colors.begin(), moved.colors.end(),
                           [](const ColorPoint& a, const ColorPoint& b) { return a.x < b.x; }),
            "points that lost their order");
  } catch (const Error& error) {
    require(std::string(error.what()).find('\n') == std::string::npos,
            "a message of several lines");
  }
}

// The input is a grid and its solution, one behind the other, split where the first byte says.
inline void plot3d(Input input) {
  if (input.empty()) return;
  const std::size_t split = 1 + (input.size() - 1) * static_cast<std::size_t>(input[0]) / 255;
  const MemoryFile grid(input.subspan(1, split - 1));
  const MemoryFile solution(input.subspan(split));
  expect_dataset_or_error([&] { return io::read_plot3d(grid.path(), {solution.path()}, {}); });
}

// By the reader's process, which HDF5's library may crash.
inline void hdf5_lattice(Input input) {
  static const std::string path = (std::filesystem::temp_directory_path() /
                                   ("ovoid_fuzz_" + std::to_string(::getpid()) + ".h5"))
                                      .string();
  static const auto session = std::make_shared<ReaderSession>(std::vector{path});
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(input.data()),
             static_cast<std::streamsize>(input.size()));
  ReadOptions options;
  options.session = session;
  expect_dataset_or_error([&] { return read_dataset({path}, options); });
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
}

// Three bytes of sizes, then runs: rows' numbers of them, starts and lengths, a byte each, and
// values.
inline void relevant_runs(Input input) {
  if (input.size() < 3) return;
  const auto byte = [&input](std::size_t i) { return static_cast<std::uint32_t>(input[i]); };
  const data::SampleBox box{ScalarType::kUInt8, {1 + byte(0), 1 + byte(1) % 32, 1 + byte(1) / 32}};
  const auto num_rows = static_cast<std::size_t>(box.dims[1] * box.dims[2]);
  if (input.size() < 3 + num_rows + 2 * byte(2)) return;
  data::RunLists lists;
  std::size_t at = 3;
  for (std::size_t i = 0; i < num_rows; ++i) lists.row_runs.push_back(byte(at++));
  for (std::size_t i = 0; i < byte(2); ++i) lists.starts.push_back(byte(at++));
  for (std::size_t i = 0; i < byte(2); ++i) lists.lengths.push_back(byte(at++));
  try {
    const data::RelevantRuns runs(box, lists, input.subspan(at), input.first(1));
    std::vector<std::byte> samples(static_cast<std::size_t>(num_samples(box.dims)));
    runs.decode({0, 0, 0}, box.dims, samples.data());
    const data::RunLists same = runs.lists();
    require(same.row_runs == lists.row_runs && same.starts == lists.starts &&
                same.lengths == lists.lengths,
            "runs that came back as others");
  } catch (const Error&) {
    // Refused: as it should be.
  }
}

inline void netcdf_header(Input input) {
  try {
    io::check_exodus(*io::open_memory("fuzz.e", input));
    io::check_hdf5_size(*io::open_memory("fuzz.e", input));
  } catch (const Error&) {
    // Refused: as it should be.
  }
}

inline void vdb_header(Input input) {
  try {
    io::read_vdb_header(*io::open_memory("fuzz.vdb", input));
  } catch (const Error& error) {
    require(std::string(error.what()).size() < 1000, "a message without end");
  }
}

inline void gltf(Input input) { read_with_files("fuzz.gltf", input); }

inline void camera(Input input) {
  const MemoryFile file(input);
  try {
    read_camera(file.path()).validate();
  } catch (const Error&) {
    // Refused: as it should be.
  }
}

}  // namespace ovoid::fuzz
