// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr_array.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/core/short_floats.h"
#include "io/core/text_file.h"
#include "io/images/npy_header.h"
#include "io/zarr/zarr_codecs.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMostZarrAxes = 32;

[[noreturn]] void refuse_zarr(const std::string& where, const std::string& what) {
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: {}", where, what));
}

// The JSON of a key; null if it is not there.
std::optional<Json> find_json(const ZarrStore& store, const std::string& key) {
  const auto source = store.find(key);
  if (source == nullptr) return std::nullopt;
  require_size(static_cast<std::size_t>(source->size()), kMaxJsonBytes, source->name());
  return parse_json(source->text(0, source->size()), source->name());
}

// How a number along each axis becomes the name of a chunk.
struct ChunkNames {
  char separator = '.';
  bool has_prefix = false;  // version 3's: "c/0/1"
};

// How version 3 puts chunks into one value of the store: an index, and what it points at.
struct Shards {
  std::vector<std::int64_t> num_chunks;  // of a shard, along each axis; empty: there are none
  bool is_index_first = false;
  std::int64_t index_size = 0;  // bytes, with its checksum
};

// Where the bytes of an array's chunks are.
struct ZarrChunks {
  ChunkNames names;
  ZarrPacking packing;
  Shards shards;
};

std::string chunk_name(const ChunkNames& names, std::span<const std::int64_t> number) {
  std::string name = names.has_prefix ? "c" : "";
  for (const std::int64_t index : number) {
    if (!name.empty()) name += names.separator;
    name += std::to_string(index);
  }
  return name.empty() ? "0" : name;
}

// --- parts of a description ---------------------------------------------------------------------

std::vector<std::int64_t> zarr_sizes(const JsonValue& list, std::size_t rank) {
  if (rank != 0) list.array_of(rank);
  if (list.array().size() > kMostZarrAxes) list.refuse("has too many axes");
  std::vector<std::int64_t> sizes;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonValue size = list.element(i);
    const double number = size.number();
    if (!(number >= 1 && number <= static_cast<double>(kMaxAxisSize)) ||
        number != std::floor(number))
      size.refuse(fmt::format("expected a whole number from 1 to {}", kMaxAxisSize));
    sizes.push_back(static_cast<std::int64_t>(number));
  }
  return sizes;
}

// A number that the type holds, in native byte order.
void set_fill(const JsonValue& fill, ChunkedArray& array) {
  const Json& json = fill.json();
  if (json.is_null()) return;
  if (array.short_float != ShortFloat::kNone) {
    ChunkedArray wide;
    wide.type = ScalarType::kFloat32;
    set_fill(fill, wide);
    const std::uint16_t bits =
        bits_of(number_at<float>(wide.fill.data(), std::endian::native == std::endian::big),
                array.short_float);
    std::memcpy(array.fill.data(), &bits, sizeof(bits));
    return;
  }
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    T value{};
    const auto out_of_range = [&] {
      fill.refuse(fmt::format("expected a {}", name_of(array.type)));
    };
    if (json.is_boolean()) {
      value = static_cast<T>(json.get<bool>());
    } else if (json.is_number_unsigned() && std::is_integral_v<T>) {
      const auto number = json.get<std::uint64_t>();
      if (number > static_cast<std::uint64_t>(std::numeric_limits<T>::max())) out_of_range();
      value = static_cast<T>(number);
    } else if (json.is_number_integer() && std::is_integral_v<T>) {
      const auto number = json.get<std::int64_t>();
      value = static_cast<T>(number);
      if (static_cast<std::int64_t>(value) != number || (number < 0 && std::is_unsigned_v<T>))
        out_of_range();
    } else if (json.is_number()) {
      const double number = json.get<double>();
      const bool is_held =
          std::is_integral_v<T>
              ? number >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
                    number < std::ldexp(1.0, std::numeric_limits<T>::digits) &&
                    number == std::floor(number)
              : std::abs(number) <= static_cast<double>(std::numeric_limits<T>::max());
      if (!is_held) out_of_range();
      value = static_cast<T>(number);
    } else if (json.is_string() && std::is_floating_point_v<T>) {
      const auto& text = json.get_ref<const std::string&>();
      constexpr T kInfinity = std::numeric_limits<T>::infinity();
      if (text == "NaN")
        value = std::numeric_limits<T>::quiet_NaN();
      else if (text == "Infinity")
        value = kInfinity;
      else if (text == "-Infinity")
        value = -kInfinity;
      else
        out_of_range();
    } else {
      out_of_range();
    }
    std::memcpy(array.fill.data(), &value, sizeof(T));
  });
}

// --- version 2 ----------------------------------------------------------------------------------

ZarrChunks describe_version_2(const JsonValue& description, ChunkedArray& array) {
  ZarrChunks chunks;
  array.shape = zarr_sizes(description.member("shape"), 0);
  array.chunk = zarr_sizes(description.member("chunks"), array.shape.size());
  const JsonValue dtype = description.member("dtype");
  if (!dtype.json().is_string()) refuse_zarr(dtype.place(), "records are not read");
  const NpyType type = npy_type_of(description.place(), dtype.string());
  array.type = type.type;
  array.short_float = type.short_float;
  array.is_big_endian = type.is_big_endian;
  const JsonValue order = description.member("order");
  if (order.string() != "C" && order.string() != "F") order.refuse("expected C or F");
  array.is_first_fastest = order.string() == "F";
  if (description.has("dimension_separator")) {
    const JsonValue separator = description.member("dimension_separator");
    if (separator.string() != "." && separator.string() != "/") separator.refuse("expected . or /");
    chunks.names.separator = separator.string()[0];
  }
  if (description.has("filters") && !description.json()["filters"].is_null()) {
    const JsonValue filters = description.member("filters");
    if (filters.array().size() > 0) {
      refuse_zarr(filters.place(),
                  fmt::format("its samples went through the filter '{}': expected none",
                              filters.element(0).member("id").string().substr(0, 40)));
    }
  }
  if (description.has("fill_value")) set_fill(description.member("fill_value"), array);
  const JsonValue compressor = description.member("compressor");
  if (!compressor.json().is_null())
    chunks.packing.codec = zarr_codec_called(compressor.place(), compressor.member("id").string());
  return chunks;
}

// --- version 3 ----------------------------------------------------------------------------------

// {"name": "bytes", "configuration": {...}}, or the name alone.
std::string extension_name(const JsonValue& extension) {
  return extension.json().is_string() ? extension.string() : extension.member("name").string();
}

// Samples to bytes: their byte order and that of the axes.
void use_order_codec(const JsonValue& codec, const std::string& name, ChunkedArray& array) {
  const bool has_configuration = codec.json().is_object() && codec.has("configuration") &&
                                 codec.json()["configuration"].is_object();
  if (name == "bytes") {
    if (!has_configuration || !codec.member("configuration").has("endian")) return;
    const JsonValue endian = codec.member("configuration").member("endian");
    if (endian.string() != "little" && endian.string() != "big")
      endian.refuse("expected little or big");
    array.is_big_endian = endian.string() == "big";
    return;
  }
  const JsonValue order = codec.member("configuration").member("order");
  const std::size_t rank = array.shape.size();
  order.array_of(rank);
  bool is_same = true, is_reversed = true;
  for (std::size_t i = 0; i < rank; ++i) {
    const double axis = order.element(i).number();
    is_same = is_same && axis == static_cast<double>(i);
    is_reversed = is_reversed && axis == static_cast<double>(rank - 1 - i);
  }
  if (!is_same && !is_reversed) order.refuse("expected the axes in their order, or in reverse");
  array.is_first_fastest = is_reversed && !is_same;
}

ZarrPacking describe_packing(const JsonValue& codecs, ChunkedArray& array) {
  ZarrPacking packing;
  codecs.array();
  for (std::size_t i = 0; i < codecs.size(); ++i) {
    const JsonValue codec = codecs.element(i);
    const std::string name = extension_name(codec);
    if (name == "bytes" || name == "transpose") {
      use_order_codec(codec, name, array);
    } else if (name == "crc32c") {
      packing.has_checksum = true;
    } else if (packing.codec != ZarrCodec::kNone || packing.has_checksum) {
      refuse_zarr(codec.place(), "is packed more than once");
    } else {
      packing.codec = zarr_codec_called(codec.place(), name);
    }
  }
  return packing;
}

// The index of a shard is not packed: each chunk's is found by itself.
Shards describe_shards(const JsonValue& configuration, ChunkedArray& array) {
  Shards shards;
  const JsonValue inner = configuration.member("chunk_shape");
  const std::vector<std::int64_t> chunk = zarr_sizes(inner, array.shape.size());
  double num_chunks = 1;
  for (std::size_t a = 0; a < chunk.size(); ++a) {
    if (array.chunk[a] % chunk[a] != 0) inner.element(a).refuse("does not divide its shard");
    shards.num_chunks.push_back(array.chunk[a] / chunk[a]);
    num_chunks *= static_cast<double>(shards.num_chunks.back());
  }
  constexpr double kMostChunks = 1 << 26;  // of a shard
  if (num_chunks > kMostChunks) inner.refuse("makes too many chunks in a shard");
  array.chunk = chunk;
  ChunkedArray index = array;
  index.is_big_endian = false;
  const JsonValue codecs = configuration.member("index_codecs");
  const ZarrPacking packing = describe_packing(codecs, index);
  if (packing.codec != ZarrCodec::kNone || index.is_big_endian)
    refuse_zarr(codecs.place(), "expected bytes, little endian, and crc32c");
  constexpr std::int64_t kEntry = 16, kSum = 4;
  shards.index_size =
      static_cast<std::int64_t>(num_chunks) * kEntry + (packing.has_checksum ? kSum : 0);
  if (configuration.has("index_location")) {
    const JsonValue location = configuration.member("index_location");
    if (location.string() != "start" && location.string() != "end")
      location.refuse("expected start or end");
    shards.is_index_first = location.string() == "start";
  }
  return shards;
}

void describe_codecs(const JsonValue& codecs, ChunkedArray& array, ZarrChunks& chunks) {
  const bool are_shards =
      codecs.array().size() > 0 && extension_name(codecs.element(0)) == "sharding_indexed";
  if (!are_shards) {
    chunks.packing = describe_packing(codecs, array);
    return;
  }
  codecs.array_of(1);
  const JsonValue configuration = codecs.element(0).member("configuration");
  chunks.shards = describe_shards(configuration, array);
  chunks.packing = describe_packing(configuration.member("codecs"), array);
}

ZarrChunks describe_version_3(const JsonValue& description, ChunkedArray& array) {
  ZarrChunks chunks;
  array.shape = zarr_sizes(description.member("shape"), 0);
  const JsonValue grid = description.member("chunk_grid");
  if (extension_name(grid) != "regular") grid.member("name").refuse("expected a regular grid");
  array.chunk = zarr_sizes(grid.member("configuration").member("chunk_shape"), array.shape.size());
  const JsonValue type = description.member("data_type");
  const std::string type_name = extension_name(type);
  for (const ShortFloat kind : {ShortFloat::kHalf, ShortFloat::kBrain})
    if (type_name == name_of(kind)) array.short_float = kind;
  const bool is_short = array.short_float != ShortFloat::kNone;
  const auto known = find_scalar_type(type_name == "bool" ? "uint8"
                                      : is_short          ? "uint16"
                                                          : type_name);
  if (!known) type.refuse("expected integers of 8 to 64 bits, or floats of 16 to 64");
  array.type = *known;
  array.is_big_endian = std::endian::native == std::endian::big;  // of samples of one byte
  const JsonValue keys = description.member("chunk_key_encoding");
  const std::string encoding = extension_name(keys);
  if (encoding != "default" && encoding != "v2") keys.refuse("expected default or v2");
  ChunkNames& names = chunks.names;
  names = {encoding == "v2" ? '.' : '/', encoding == "default"};
  if (keys.json().is_object() && keys.has("configuration") &&
      keys.member("configuration").object().has("separator")) {
    const JsonValue separator = keys.member("configuration").member("separator");
    if (separator.string() != "." && separator.string() != "/") separator.refuse("expected . or /");
    names.separator = separator.string()[0];
  }
  if (description.has("fill_value")) set_fill(description.member("fill_value"), array);
  if (description.has("storage_transformers") &&
      description.member("storage_transformers").array().size() > 0)
    refuse_zarr(description.place(), "storage transformers are not read");
  describe_codecs(description.member("codecs"), array, chunks);
  return chunks;
}

// --- chunks -------------------------------------------------------------------------------------

// What does not pack at all grows a little.
constexpr std::int64_t kMostPacked = ChunkedArray::kMostChunkBytes + (std::int64_t{64} << 20);

// A piece of a value.
struct PackedChunk {
  std::int64_t offset = 0, size = 0;
};

// Where in a shard a chunk is; nothing if it is not there. `number` counts in the shard.
std::optional<PackedChunk> find_in_shard(const ByteSource& source, const Shards& shards,
                                         std::span<const std::int64_t> number) {
  if (source.size() < shards.index_size)
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: is shorter than a shard's index", source.name()));
  std::int64_t entry = 0;
  for (std::size_t a = 0; a < number.size(); ++a) entry = entry * shards.num_chunks[a] + number[a];
  std::array<std::byte, 16> bytes{};
  const std::int64_t index = shards.is_index_first ? 0 : source.size() - shards.index_size;
  source.read(index + 16 * entry, bytes);
  const auto offset = number_at<std::uint64_t>(bytes.data(), false);
  const auto size = number_at<std::uint64_t>(bytes.data() + 8, false);
  constexpr std::uint64_t kNotThere = ~std::uint64_t{0};
  if (offset == kNotThere && size == kNotThere) return std::nullopt;
  const auto all = static_cast<std::uint64_t>(source.size());
  if (size > all || offset > all - size) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: chunk {}: lies outside the file", source.name(), entry));
  }
  return PackedChunk{static_cast<std::int64_t>(offset), static_cast<std::int64_t>(size)};
}

// ChunkedArray::read of what `store` has below `key`.
bool read_zarr_chunk(const ZarrStore& store, const std::string& key, const ZarrChunks& chunks,
                     std::span<const std::int64_t> number, std::span<std::byte> out) {
  std::vector<std::int64_t> outer(number.begin(), number.end()), inner;
  for (std::size_t a = 0; a < chunks.shards.num_chunks.size(); ++a) {
    inner.push_back(outer[a] % chunks.shards.num_chunks[a]);
    outer[a] /= chunks.shards.num_chunks[a];
  }
  const auto source = store.find(zarr_key(key, chunk_name(chunks.names, outer)));
  if (source == nullptr) return false;
  PackedChunk chunk{0, source->size()};
  if (!inner.empty()) {
    const auto found = find_in_shard(*source, chunks.shards, inner);
    if (!found) return false;
    chunk = *found;
  }
  if (chunk.size > kMostPacked)
    refuse_zarr(source->name(), fmt::format("has {} bytes: expected a chunk", chunk.size));
  if (chunks.packing.codec == ZarrCodec::kNone && !chunks.packing.has_checksum &&
      chunk.size == static_cast<std::int64_t>(out.size())) {
    source->read(chunk.offset, out);
    return true;
  }
  std::vector<std::byte> packed(static_cast<std::size_t>(chunk.size));
  source->read(chunk.offset, packed);
  unpack_zarr_chunk(source->name(), packed, chunks.packing, out);
  return true;
}

}  // namespace

std::optional<ZarrNode> find_zarr_node(const ZarrStore& store, const std::string& key,
                                       std::vector<std::string>* notes) {
  ZarrNode node;
  node.key = key;
  node.attributes = Json::object();
  const auto describe = [&](const char* file) {
    const std::string described = zarr_key(key, file);
    auto json = find_json(store, described);
    if (!json) return false;
    node.where = store.name_of(described);
    node.description = std::move(*json);
    JsonValue(node.description, node.where + ": ").object();
    return true;
  };
  node.is_array = describe(".zarray");
  if (!node.is_array && !describe(".zgroup")) {
    if (!describe("zarr.json")) return std::nullopt;
    const JsonValue root(node.description, node.where + ": ");
    if (root.member("zarr_format").number() != 3)
      refuse_zarr(root.place(), "expected Zarr's version 2 or 3");
    node.version = 3;
    node.is_array = root.member("node_type").string() == "array";
    if (root.has("attributes") && root.json()["attributes"].is_object())
      node.attributes = root.json()["attributes"];
    node.attributes_where = node.where + ": attributes";
    return node;
  }
  const JsonValue root(node.description, node.where + ": ");
  if (root.member("zarr_format").number() != 2)
    refuse_zarr(node.where, "expected Zarr's version 2 or 3");
  const std::string attributes = zarr_key(key, ".zattrs");
  node.attributes_where = store.name_of(attributes) + ": ";
  try {
    auto json = find_json(store, attributes);
    if (json && json->is_object()) node.attributes = std::move(*json);
  } catch (const Error& error) {
    // Python writes NaN there, which JSON has not.
    if (notes != nullptr) notes->push_back(fmt::format("{}: passed over", error.what()));
  }
  return node;
}

ChunkedArray zarr_array(const std::shared_ptr<const ZarrStore>& store, const ZarrNode& node) {
  ChunkedArray array;
  array.where = store->name_of(node.key);
  const JsonValue description(node.description, node.where + ": ");
  const ZarrChunks chunks = node.version == 2 ? describe_version_2(description, array)
                                              : describe_version_3(description, array);
  array.read = [store, chunks, key = node.key](std::span<const std::int64_t> number,
                                               std::span<std::byte> out) {
    return read_zarr_chunk(*store, key, chunks, number, out);
  };
  return array;
}

std::vector<std::string> zarr_axis_names(const ZarrNode& node) {
  const bool is_version_3 = node.version == 3;
  const Json& holder = is_version_3 ? node.description : node.attributes;
  const char* const name = is_version_3 ? "dimension_names" : "_ARRAY_DIMENSIONS";
  const auto found = holder.find(name);
  std::vector<std::string> names;
  if (found == holder.end() || !found->is_array()) return names;
  for (const Json& axis : *found) names.push_back(axis.is_string() ? axis.get<std::string>() : "");
  return names;
}

}  // namespace ovoid::io
