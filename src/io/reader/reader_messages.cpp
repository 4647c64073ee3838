// SPDX-License-Identifier: Apache-2.0
#include "io/reader/reader_messages.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <span>

#include "io/check_dataset.h"
#include "io/core/json_file.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/meshes/mesh_parts.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kAlignment = 64;

constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE;

[[noreturn]] void nonsense(const std::string& what) {
  throw Error(ErrorCode::kFileFormat, "its reader sent " + what);
}

// Everything that a message may be wrong in becomes an Error here.
template <typename Read>
auto parsed(const std::vector<std::uint8_t>& message, const Read& read) {
  try {
    return read(Json::from_msgpack(message));
  } catch (const Json::exception&) {
    nonsense("a message that is none");
  }
}

template <typename Enum>
Enum enum_of(const Json& json, Enum last) {
  const auto value = json.get<std::int64_t>();
  if (value < 0 || value > static_cast<std::int64_t>(last)) nonsense("an unknown kind");
  return static_cast<Enum>(value);
}

std::int64_t count_of(const Json& json) {
  const auto value = json.get<std::int64_t>();
  if (value < 0 || value > kMaxNumBytes) nonsense("an impossible count");
  return value;
}

// --- the memory ---------------------------------------------------------------------------------

// Lays arrays one behind the other.
class MemoryWriter {
 public:
  explicit MemoryWriter(std::size_t num_bytes)
      : fd_(::memfd_create("ovoid-dataset", MFD_CLOEXEC | MFD_ALLOW_SEALING)), size_(num_bytes) {
    if (!fd_.is_open() || ::ftruncate(fd_.get(), static_cast<off_t>(num_bytes)) != 0) refuse();
    if (num_bytes == 0) return;
    void* const at = ::mmap(nullptr, num_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_.get(), 0);
    if (at == MAP_FAILED) refuse();
    memory_ = static_cast<std::byte*>(at);
  }
  ~MemoryWriter() { unmap(); }
  MemoryWriter(const MemoryWriter&) = delete;
  MemoryWriter& operator=(const MemoryWriter&) = delete;

  static std::size_t padded(std::size_t num_bytes) {
    return (num_bytes + kAlignment - 1) / kAlignment * kAlignment;
  }

  // Where the bytes are now: [offset, size].
  Json add(std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(memory_ + used_, bytes.data(), bytes.size());
    Json place = Json::array({used_, bytes.size()});
    used_ += padded(bytes.size());
    return place;
  }

  UniqueFd finish() {
    unmap();
    if (::fcntl(fd_.get(), F_ADD_SEALS, kSeals) != 0) refuse();
    return std::move(fd_);
  }

 private:
  [[noreturn]] void refuse() const {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("{} bytes of shared memory for what was read: the system has none left",
                            size_));
  }
  void unmap() {
    if (memory_ != nullptr) ::munmap(memory_, size_);
    memory_ = nullptr;
  }

  UniqueFd fd_;
  std::size_t size_;
  std::size_t used_ = 0;
  std::byte* memory_ = nullptr;
};

// Sealed memory, mapped for as long as somebody holds it.
class SharedMemory {
 public:
  explicit SharedMemory(const UniqueFd& fd) {
    struct stat status {};
    if (!fd.is_open() || (::fcntl(fd.get(), F_GET_SEALS) & kSeals) != kSeals ||
        ::fstat(fd.get(), &status) != 0)
      nonsense("memory that is not sealed");
    size_ = static_cast<std::size_t>(status.st_size);
    if (size_ == 0) return;
    at_ = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, fd.get(), 0);
    if (at_ == MAP_FAILED) {
      throw Error(
          ErrorCode::kOutOfMemory,
          fmt::format("{} bytes of address space for what was read: the system has none left",
                      size_));
    }
  }
  ~SharedMemory() {
    if (size_ != 0) ::munmap(at_, size_);
  }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  std::span<const std::byte> bytes() const noexcept {
    return {static_cast<const std::byte*>(at_), size_};
  }

 private:
  void* at_ = nullptr;
  std::size_t size_ = 0;
};

using Shared = std::shared_ptr<const SharedMemory>;

Bytes bytes_at(const Json& place, const Shared& memory) {
  const std::span<const std::byte> all = memory->bytes();
  const auto offset = static_cast<std::uint64_t>(count_of(place.at(0)));
  const auto size = static_cast<std::uint64_t>(count_of(place.at(1)));
  if (offset % kAlignment != 0 || offset > all.size() || size > all.size() - offset)
    nonsense("an array outside its memory");
  return {memory, all.subspan(offset, size)};
}

template <typename T>
SharedValues<T> values_at(const Json& place, const Shared& memory) {
  const Bytes bytes = bytes_at(place, memory);
  if (bytes.view.size() % sizeof(T) != 0) nonsense("an array with half a number");
  return {bytes.owner,
          {reinterpret_cast<const T*>(bytes.view.data()), bytes.view.size() / sizeof(T)}};
}

// --- the parts of a dataset ---------------------------------------------------------------------

// Samples that stay in the file.
Json json_of(const StoredSamples& samples) {
  const StoredPlace& place = stored_place(samples);
  Json json{{"is_big_endian", place.is_big_endian}, {"offset", place.offset}};
  if (!place.chunked) return json;
  std::vector<std::int64_t> chunks;
  for (const ChunkedStorage::Chunk& chunk : place.chunked->chunks) {
    chunks.push_back(chunk.offset);
    chunks.push_back(chunk.num_bytes);
  }
  json["dims"] = place.chunked->dims;
  json["chunk"] = place.chunked->chunk;
  json["is_shuffled"] = place.chunked->is_shuffled;
  json["is_deflated"] = place.chunked->is_deflated;
  json["chunks"] = chunks;
  return json;
}

StoredPlace stored_place(const Json& json) {
  StoredPlace place;
  place.is_big_endian = json.at("is_big_endian");
  place.offset = count_of(json.at("offset"));
  if (!json.contains("chunks")) return place;
  ChunkedStorage chunked;
  chunked.dims = json.at("dims").get<std::vector<std::int64_t>>();
  chunked.chunk = json.at("chunk").get<std::vector<std::int64_t>>();
  chunked.is_shuffled = json.at("is_shuffled");
  chunked.is_deflated = json.at("is_deflated");
  const auto chunks = json.at("chunks").get<std::vector<std::int64_t>>();
  for (std::size_t i = 0; i + 1 < chunks.size(); i += 2)
    chunked.chunks.push_back({chunks[i], chunks[i + 1]});
  place.chunked = std::make_shared<const ChunkedStorage>(std::move(chunked));
  return place;
}

Json json_of(DataArray array, MemoryWriter& memory) {
  return {{"name", array.name},
          {"type", static_cast<int>(array.type)},
          {"components", array.num_components},
          {"tuples", array.num_tuples},
          {"unit", array.unit},
          {"is_cell_data", array.is_cell_data},
          {"scale", array.value_scale},
          {"offset", array.value_offset},
          {"at", memory.add(array.bytes.view)},
          {"in_file", array.stored ? json_of(*array.stored) : Json()}};
}

DataArray array_of(const Json& json, const Shared& memory, const ReaderHost& host,
                   const Dataset& dataset) {
  DataArray array;
  array.name = json.at("name");
  array.type = enum_of(json.at("type"), ScalarType::kFloat64);
  const std::int64_t num_components = count_of(json.at("components"));
  array.num_tuples = count_of(json.at("tuples"));
  array.unit = json.at("unit");
  array.is_cell_data = json.at("is_cell_data");
  array.value_scale = json.at("scale");
  array.value_offset = json.at("offset");
  array.bytes = bytes_at(json.at("at"), memory);
  if (num_components > std::numeric_limits<int>::max()) nonsense("too many components");
  array.num_components = static_cast<int>(num_components);
  const std::array factors{num_components, array.num_tuples,
                           static_cast<std::int64_t>(size_of(array.type))};
  const std::int64_t num_bytes = checked_product(factors).value_or(-1);
  if (const Json& in_file = json.at("in_file"); !in_file.is_null()) {
    if (!host.options.may_stay_in_file || num_components != 1)
      nonsense("an array that it left in its file");
    StoredPlace place = stored_place(in_file);
    place.type = array.type;
    place.num_bytes = num_bytes;
    array.stored = samples_in_file(*open_file(host.file_of(dataset)), place, host.options);
  } else if (num_bytes != static_cast<std::int64_t>(array.bytes.view.size())) {
    nonsense("an array of another size than its own");
  }
  return array;
}

Json json_of(const LatticeGeometry& lattice) {
  std::vector<double> matrix;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row)
      matrix.push_back(lattice.world_from_index.matrix()(row, column));
  return {{"dims", lattice.dims}, {"matrix", matrix}, {"kind", static_cast<int>(lattice.kind)}};
}

LatticeGeometry lattice_of(const Json& json) {
  LatticeGeometry lattice;
  for (std::size_t axis = 0; axis < 3; ++axis)
    lattice.dims[axis] = count_of(json.at("dims").at(axis));
  std::size_t next = 0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row)
      lattice.world_from_index.matrix()(row, column) = json.at("matrix").at(next++);
  lattice.kind = enum_of(json.at("kind"), LatticeKind::kBodyCentred);
  return lattice;
}

Json json_of(Cells cells, MemoryWriter& memory) {
  return {{"types", memory.add(std::as_bytes(cells.types.view()))},
          {"offsets", memory.add(std::as_bytes(cells.offsets.view()))},
          {"connectivity", memory.add(std::as_bytes(cells.connectivity.view()))},
          {"dims", cells.dims}};
}

Cells cells_of(const Json& json, const Shared& memory) {
  Cells cells;
  cells.types = values_at<CellType>(json.at("types"), memory);
  cells.offsets = values_at<std::int64_t>(json.at("offsets"), memory);
  cells.connectivity = values_at<std::uint32_t>(json.at("connectivity"), memory);
  for (std::size_t axis = 0; axis < 3; ++axis)
    cells.dims[axis] = count_of(json.at("dims").at(axis));
  for (const CellType type : cells.types)
    if (type > CellType::kOther) nonsense("an unknown type of cell");
  return cells;
}

Json json_of(const std::optional<Bounds3>& box) {
  if (!box) return nullptr;
  return {box->min().x(), box->min().y(), box->min().z(),
          box->max().x(), box->max().y(), box->max().z()};
}

std::optional<Bounds3> box_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  Bounds3 box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min()[axis] = json.at(static_cast<std::size_t>(axis));
    box.max()[axis] = json.at(static_cast<std::size_t>(axis) + 3);
  }
  return box;
}

Json json_of(const std::optional<Vec3>& vector) {
  return vector ? Json::array({vector->x(), vector->y(), vector->z()}) : Json();
}

Json json_of(const std::optional<RowShare>& share) {
  return share ? Json::array({share->number, share->count}) : Json();
}

Json json_of(const std::optional<DatasetShare>& share, MemoryWriter& memory) {
  if (!share) return {};
  return Json::array({share->first, share->total, memory.add(std::as_bytes(share->nodes.view()))});
}

std::optional<RowShare> row_share_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  const std::optional share(RowShare{json.at(0), json.at(1)});
  check_share(share);
  return share;
}

std::optional<DatasetShare> dataset_share_of(const Json& json, const Shared& memory) {
  if (json.is_null()) return std::nullopt;
  return DatasetShare{count_of(json.at(0)), count_of(json.at(1)),
                      values_at<std::uint64_t>(json.at(2), memory)};
}

// Bytes that the arrays take in the memory.
std::size_t num_shared_bytes(const Dataset& dataset) {
  const auto padded = [](std::size_t size) { return MemoryWriter::padded(size); };
  std::size_t size = padded(dataset.positions.bytes.view.size()) +
                     padded(dataset.box_sizes.bytes.view.size()) +
                     padded(dataset.cells.types.size() * sizeof(CellType)) +
                     padded(dataset.cells.offsets.size() * sizeof(std::int64_t)) +
                     padded(dataset.cells.connectivity.size() * sizeof(std::uint32_t));
  for (const DataArray& array : dataset.arrays) size += padded(array.bytes.view.size());
  if (dataset.share) size += padded(dataset.share->nodes.size() * sizeof(std::uint64_t));
  return size;
}

Dataset dataset_of(const Json& json, const Shared& memory, const ReaderHost& host) {
  Dataset dataset;
  dataset.source = json.at("source");
  dataset.format = json.at("format");
  dataset.kind = enum_of(json.at("kind"), DatasetKind::kKernels);
  dataset.lattice = lattice_of(json.at("lattice"));
  dataset.positions = array_of(json.at("positions"), memory, host, dataset);
  dataset.cells = cells_of(json.at("cells"), memory);
  dataset.box_sizes = array_of(json.at("box_sizes"), memory, host, dataset);
  dataset.periodic_box = box_of(json.at("periodic_box"));
  dataset.share = dataset_share_of(json.at("share"), memory);
  dataset.space = enum_of(json.at("space"), Space::kRas);
  for (const Json& array : json.at("arrays"))
    dataset.arrays.push_back(array_of(array, memory, host, dataset));
  for (const Json& block : json.at("blocks")) dataset.blocks.push_back({block.at(0), block.at(1)});
  dataset.block = json.at("block");
  dataset.num_steps = count_of(json.at("num_steps"));
  dataset.step = count_of(json.at("step"));
  dataset.series = enum_of(json.at("series"), SeriesKind::kStaggered);
  dataset.times = json.at("times").get<std::vector<double>>();
  dataset.time_unit = json.at("time_unit");
  dataset.notes = json.at("notes").get<std::vector<std::string>>();
  return dataset;
}

// Cells are shared out by layers or pieces, which the reader knows alone.
void check_cells_of_share(const Dataset& dataset) {
  const auto& [first, total, nodes, array] = *dataset.share;
  if (total < 1 || first > total || dataset.cells.count() > total - first)
    nonsense(fmt::format("{} cells from {} of {}", dataset.cells.count(), first, total));
  if (std::ssize(nodes) != dataset.num_positions() || !std::is_sorted(nodes.begin(), nodes.end()))
    nonsense("nodes of a share without their numbers in the whole");
}

// The rows are those that were asked for.
void check_rows(const std::optional<RowShare>& share, const Dataset& dataset) {
  const bool is_share = share && has_rows(dataset.kind);
  if (is_share != dataset.share.has_value())
    nonsense(is_share ? "all rows instead of a share" : "a share instead of all");
  if (!is_share) return;
  if (dataset.kind == DatasetKind::kMesh) return check_cells_of_share(dataset);
  const Rows rows = rows_of_share(share, dataset.share->total);
  if (dataset.share->total < 1 || dataset.share->first != rows.first ||
      dataset.num_positions() != rows.count)
    nonsense(fmt::format("{} rows from {} of {}, which is another share", dataset.num_positions(),
                         dataset.share->first, dataset.share->total));
}

// A share without rows, which would be no mesh.
void check_no_rows(const Dataset& dataset) {
  if (dataset.cells.count() != 0) nonsense("cells without nodes");
}

// That the parts fit each other, and what they hold.
void check_parts(const ReaderHost& host, const Dataset& dataset) {
  check_rows(host.options.share, dataset);
  try {
    check_dataset(dataset);
  } catch (const Error& error) {
    nonsense(error.what());
  }
  if (dataset.share && dataset.num_positions() == 0) return check_no_rows(dataset);
  if (dataset.kind == DatasetKind::kLattice) return;
  MeshPart part;
  part.positions = dataset.positions;
  part.cells = dataset.cells;
  if (dataset.kind == DatasetKind::kMesh) part.arrays = dataset.arrays;
  check_mesh(host.source, part);
}

}  // namespace

const std::string& ReaderHost::file_of(const Dataset& dataset) const {
  const auto found = std::find(paths.begin(), paths.end(), dataset.source);
  return found == paths.end() ? paths.front() : *found;
}

std::vector<std::uint8_t> to_message(const ReaderRequest& request) {
  const ReadOptions& options = request.options;
  return Json::to_msgpack({{"protocol", kReaderProtocol},
                           {"format", request.format},
                           {"source", request.source},
                           {"paths", request.paths},
                           {"folder", request.folder},
                           {"array", options.array},
                           {"block", options.block},
                           {"axis_order", options.raw.axis_order},
                           {"spacing", json_of(options.raw.spacing)},
                           {"step", options.step ? Json(*options.step) : Json()},
                           {"positions", options.hdf5.positions},
                           {"values", options.hdf5.values},
                           {"may_stay_in_file", options.may_stay_in_file},
                           {"faces", options.faces},
                           {"share", json_of(options.share)},
                           {"memory", request.memory},
                           {"files", request.files},
                           {"folders", request.folders}});
}

ReaderRequest request_from_message(const std::vector<std::uint8_t>& message) {
  return parsed(message, [](const Json& json) {
    if (json.at("protocol") != kReaderProtocol) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("ovoid-read is of another version than the library (protocol {}, the "
                              "library's is {}): install both from one build",
                              kReaderProtocol, json.at("protocol").dump()));
    }
    ReaderRequest request;
    request.format = json.at("format");
    request.source = json.at("source");
    request.paths = json.at("paths").get<std::vector<std::string>>();
    request.folder = json.at("folder");
    request.options.array = json.at("array");
    request.options.block = json.at("block");
    request.options.raw.axis_order = json.at("axis_order");
    if (const Json& spacing = json.at("spacing"); !spacing.is_null())
      request.options.raw.spacing = Vec3(spacing.at(0), spacing.at(1), spacing.at(2));
    if (!json.at("step").is_null()) request.options.step = json.at("step").get<std::int64_t>();
    request.options.hdf5.positions = json.at("positions");
    request.options.hdf5.values = json.at("values").get<std::vector<std::string>>();
    request.options.may_stay_in_file = json.at("may_stay_in_file");
    request.options.faces = json.at("faces");
    request.options.share = row_share_of(json.at("share"));
    request.memory = count_of(json.at("memory"));
    request.files = json.at("files").get<std::vector<std::string>>();
    request.folders = json.at("folders").get<std::vector<std::string>>();
    return request;
  });
}

std::vector<std::uint8_t> to_message(const Error& error) {
  return Json::to_msgpack({{"code", static_cast<int>(error.code())}, {"what", error.what()}});
}

Error error_from_message(const std::vector<std::uint8_t>& message) {
  return parsed(message, [](const Json& json) {
    return Error(enum_of(json.at("code"), ErrorCode::kCancelled),
                 json.at("what").get<std::string>());
  });
}

DatasetMessage to_message(Dataset dataset) {
  MemoryWriter memory(num_shared_bytes(dataset));
  Json arrays = Json::array(), blocks = Json::array();
  for (DataArray& array : dataset.arrays) arrays.push_back(json_of(std::move(array), memory));
  for (const DatasetBlock& block : dataset.blocks)
    blocks.push_back(Json::array({block.name, block.description}));
  const Json json{{"source", dataset.source},
                  {"format", dataset.format},
                  {"kind", static_cast<int>(dataset.kind)},
                  {"lattice", json_of(dataset.lattice)},
                  {"positions", json_of(std::move(dataset.positions), memory)},
                  {"cells", json_of(std::move(dataset.cells), memory)},
                  {"box_sizes", json_of(std::move(dataset.box_sizes), memory)},
                  {"periodic_box", json_of(dataset.periodic_box)},
                  {"share", json_of(dataset.share, memory)},
                  {"space", static_cast<int>(dataset.space)},
                  {"arrays", arrays},
                  {"blocks", blocks},
                  {"block", dataset.block},
                  {"num_steps", dataset.num_steps},
                  {"step", dataset.step},
                  {"series", static_cast<int>(dataset.series)},
                  {"times", dataset.times},
                  {"time_unit", dataset.time_unit},
                  {"notes", dataset.notes}};
  return {Json::to_msgpack(json), memory.finish()};
}

Dataset dataset_from_message(const ReaderHost& host, const DatasetMessage& message) {
  const std::string& source = host.source;
  try {
    const auto memory = std::make_shared<const SharedMemory>(message.memory);
    Dataset dataset = parsed(message.description,
                             [&](const Json& json) { return dataset_of(json, memory, host); });
    check_parts(host, dataset);
    return dataset;
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", source, error.what()));
  }
}

}  // namespace ovoid::io
