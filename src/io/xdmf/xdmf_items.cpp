// SPDX-License-Identifier: Apache-2.0
#include "io/xdmf/xdmf_items.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/numbers.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kLongestName = 4096;
constexpr std::size_t kMostAxes = 8;

std::atomic<XdmfHdf5> hdf5_reader{nullptr};

std::string item_kind(const XdmfTree& tree, XdmfNode item) {
  const std::string kind = lower(tree.attribute(item, {"ItemType", "Type"}));
  return kind.empty() ? "uniform" : kind;
}

std::string item_format(const XdmfTree& tree, XdmfNode item) {
  const std::string format = lower(tree.attribute(item, {"Format"}));
  return format.empty() ? "xml" : format;
}

ScalarType item_type(const XdmfTree& tree, XdmfNode item) {
  std::string kind = lower(tree.attribute(item, {"NumberType", "DataType"}));
  if (kind.empty()) kind = "float";
  std::string precision = tree.attribute(item, {"Precision"});
  if (precision.empty()) precision = kind.ends_with("char") ? "1" : "4";
  struct Known {
    const char* kind;
    const char* precision;
    ScalarType type;
  };
  static constexpr Known kKnown[] = {
      {"float", "4", ScalarType::kFloat32}, {"float", "8", ScalarType::kFloat64},
      {"int", "1", ScalarType::kInt8},      {"int", "2", ScalarType::kInt16},
      {"int", "4", ScalarType::kInt32},     {"int", "8", ScalarType::kInt64},
      {"uint", "1", ScalarType::kUInt8},    {"uint", "2", ScalarType::kUInt16},
      {"uint", "4", ScalarType::kUInt32},   {"uint", "8", ScalarType::kUInt64},
      {"char", "1", ScalarType::kInt8},     {"uchar", "1", ScalarType::kUInt8},
      {"short", "2", ScalarType::kInt16},   {"ushort", "2", ScalarType::kUInt16}};
  for (const Known& known : kKnown)
    if (kind == known.kind && precision == known.precision) return known.type;
  tree.refuse(item, fmt::format("has NumberType '{}' of Precision '{}': expected Float of 4 or 8, "
                                "Int or UInt of 1, 2, 4 or 8, Char or UChar",
                                kind.substr(0, 40), precision.substr(0, 40)));
}

std::int64_t product(std::span<const std::int64_t> dims) {
  std::int64_t count = 1;
  for (const std::int64_t dim : dims) count *= dim;
  return count;
}

// The number that a word is, as T; nothing if it is none or does not fit.
template <typename T>
std::optional<T> number_of_word(std::string_view word) {
  if constexpr (std::is_floating_point_v<T>) {
    const auto value = parse_number<double>(word);
    return value ? std::optional(static_cast<T>(*value)) : std::nullopt;
  } else {
    if (const auto value = parse_number<T>(word)) return value;
    // "3.0" or "1e3"
    const auto value = parse_real(word);
    if (!value || *value != std::floor(*value) ||
        *value < static_cast<double>(std::numeric_limits<T>::lowest()) ||
        *value >= std::ldexp(1.0, std::numeric_limits<T>::digits))
      return std::nullopt;
    return static_cast<T>(*value);
  }
}

// What is taken of an array: along each of its axes.
struct XdmfSlab {
  std::vector<std::int64_t> start, stride, count;

  // All that was read, of an array of these sizes?
  bool is_all_of(const XdmfNumbers& rows, const std::vector<std::int64_t>& dims) const {
    return stride[0] == 1 && product(count) == rows.count() &&
           std::equal(count.begin() + 1, count.end(), dims.begin() + 1);
  }
};

XdmfSlab slab_of(const XdmfTree& tree, XdmfNode item, const XdmfNumbers& choice,
                 const std::vector<std::int64_t>& dims) {
  const std::size_t rank = dims.size();
  if (choice.count() != static_cast<std::int64_t>(3 * rank)) {
    tree.fail(item, fmt::format("has {} numbers of start, stride and count: expected 3 for each "
                                "of {} axes",
                                choice.count(), rank));
  }
  XdmfSlab slab;
  for (std::size_t axis = 0; axis < rank; ++axis) {
    const auto value = [&](std::size_t row) {
      const double number = choice.number(static_cast<std::int64_t>(row * rank + axis));
      return number >= 0 && number <= static_cast<double>(kMaxAxisSize) &&
                     number == std::floor(number)
                 ? static_cast<std::int64_t>(number)
                 : -1;
    };
    const std::int64_t start = value(0), stride = value(1), count = value(2);
    if (start < 0 || stride < 1 || count < 1 || start + (count - 1) * stride >= dims[axis]) {
      tree.fail(item, fmt::format("takes {} from {} by {} of axis {}, which has {}", count, start,
                                  stride, axis, dims[axis]));
    }
    slab.start.push_back(start);
    slab.stride.push_back(stride);
    slab.count.push_back(count);
  }
  return slab;
}

// `dims`: of the array, of which `rows` are all or some along the slowest axis.
XdmfNumbers taken_from(const XdmfNumbers& rows, const XdmfSlab& slab,
                       const std::vector<std::int64_t>& dims) {
  const std::size_t rank = dims.size();
  const auto size = static_cast<std::int64_t>(size_of(rows.type));
  std::vector<std::int64_t> steps(rank, size);
  for (std::size_t axis = rank - 1; axis-- > 0;) steps[axis] = steps[axis + 1] * dims[axis + 1];
  XdmfNumbers taken{slab.count, rows.type, {}};
  const std::int64_t total = product(slab.count);
  // Numbers that lie side by side are taken at once.
  const std::int64_t run = slab.stride.back() == 1 ? slab.count.back() : 1;
  SampleBuffer buffer;
  std::byte* out = buffer.extend(total * size, total * size).data();
  std::vector<std::int64_t> at(rank, 0);
  for (std::int64_t i = 0; i < total; i += run, out += run * size) {
    std::int64_t offset = 0;
    for (std::size_t axis = 0; axis < rank; ++axis)
      offset += (slab.start[axis] + at[axis] * slab.stride[axis]) * steps[axis];
    std::memcpy(out, rows.bytes.view.data() + offset, static_cast<std::size_t>(run * size));
    at[rank - 1] += run - 1;
    for (std::size_t axis = rank; axis-- > 0 && ++at[axis] == slab.count[axis];) at[axis] = 0;
  }
  taken.bytes = buffer.release();
  return taken;
}

}  // namespace

double XdmfNumbers::number(std::int64_t index) const {
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(data::load_scalar<T>(bytes.view.data(), index));
  });
}

void set_xdmf_hdf5(XdmfHdf5 reader) noexcept { hdf5_reader = reader; }

bool has_xdmf_hdf5() noexcept { return hdf5_reader.load() != nullptr; }

bool is_xdmf_hdf5(const XdmfTree& tree, XdmfNode item) {
  return xml_name(item) == "DataItem" && item_format(tree, item).starts_with("hdf");
}

bool is_xdmf_binary(const XdmfTree& tree, XdmfNode item) {
  return xml_name(item) == "DataItem" && item_format(tree, item) == "binary";
}

XdmfHdf5Name xdmf_hdf5_name(const XdmfTree& tree, XdmfNode item) {
  const std::string text = tree.text(item, kLongestName);
  const auto colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size())
    tree.fail(item,
              fmt::format("is '{}': expected FILE:/PATH of an HDF5 file", text.substr(0, 200)));
  if (text.find('|') != std::string::npos)
    tree.refuse(item,
                fmt::format("is '{}': selections behind | are not read", text.substr(0, 200)));
  return {path_beside(tree.source().name(), std::string(trimmed(text.substr(0, colon)))),
          std::string(trimmed(text.substr(colon + 1)))};
}

std::string xdmf_binary_name(const XdmfTree& tree, XdmfNode item) {
  const std::string text = tree.text(item, kLongestName);
  if (text.empty()) tree.fail(item, "names no file");
  return path_beside(tree.source().name(), text);
}

bool is_xdmf_formula(const XdmfTree& tree, XdmfNode item) {
  const std::string kind = item_kind(tree, item);
  if (kind == "coordinates") return true;
  if (kind != "function") return false;
  std::string formula = lower(tree.attribute(item, {"Function"}));
  std::erase_if(formula, is_blank);
  constexpr std::size_t kMostParts = 9;
  const std::size_t num_parts = tree.children(item, "DataItem").size();
  if (num_parts < 1 || num_parts > kMostParts) return true;
  std::string join;
  for (std::size_t i = 0; i < num_parts; ++i) join += fmt::format("{}${}", i == 0 ? "" : ",", i);
  return formula != fmt::format("join({})", join);
}

std::vector<std::int64_t> xdmf_dims(const XdmfTree& tree, XdmfNode element,
                                    const std::string& text) {
  std::vector<std::int64_t> dims;
  for (const std::string_view word : words(text)) {
    if (dims.size() == kMostAxes)
      tree.refuse(element, fmt::format("has more than {} Dimensions", kMostAxes));
    dims.push_back(parse_integer(word).value_or(-1));
  }
  const auto count = checked_product(dims);
  if (dims.empty() || *std::min_element(dims.begin(), dims.end()) < 1 || !count ||
      *count > kMaxNumBytes / 8) {
    tree.fail(element, fmt::format("has Dimensions '{}': expected whole numbers from 1",
                                   text.substr(0, 80)));
  }
  return dims;
}

// The whole text is read, whatever rows are asked for: all of them are, then.
XdmfStored XdmfItems::stored_text(XdmfNode item, ScalarType type) const {
  std::vector<std::int64_t> dims = xdmf_dims(tree_, item, tree_.attribute(item, {"Dimensions"}));
  const std::int64_t count = product(dims);
  const auto text = std::make_shared<const std::string>(xml_text(item));
  // A number takes a letter and a blank at least.
  if (count > static_cast<std::int64_t>(text->size() + 1) / 2) {
    tree_.fail(item,
               fmt::format("has {} bytes of text, too few for {} numbers", text->size(), count));
  }
  XdmfStored stored{std::move(dims), type, {}};
  stored.read = [this, item, type, count, text](std::int64_t, std::span<std::byte> out) {
    const auto source = open_memory(tree_.source().name(), std::as_bytes(std::span(*text)));
    TextScanner scanner(*source, 0, source->size());
    data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
      for (std::int64_t i = 0; i < count; ++i) {
        const std::string_view word = scanner.word();
        if (word.empty()) tree_.fail(item, fmt::format("has {} numbers of {}", i, count));
        const auto value = number_of_word<T>(word);
        if (!value) {
          tree_.fail(item, fmt::format("number {} is '{}': expected one of {}", i,
                                       word.substr(0, 40), name_of(type)));
        }
        std::memcpy(out.data() + static_cast<std::size_t>(i) * sizeof(T), &*value, sizeof(T));
      }
    });
    if (!scanner.word().empty())
      tree_.fail(item, fmt::format("has more numbers than the {} of its Dimensions", count));
  };
  return stored;
}

XdmfStored XdmfItems::stored_binary(XdmfNode item, ScalarType type) const {
  const std::string compression = lower(tree_.attribute(item, {"Compression"}));
  if (!compression.empty() && compression != "raw" && compression != "none")
    tree_.refuse(item, fmt::format("is compressed by '{}', which is not read: expected Raw",
                                   compression.substr(0, 40)));
  const std::string endian = lower(tree_.attribute(item, {"Endian"}));
  if (!endian.empty() && endian != "native" && endian != "little" && endian != "big")
    tree_.fail(
        item, fmt::format("has Endian '{}': expected Little, Big or Native", endian.substr(0, 40)));
  const bool is_big = endian == "big" || ((endian.empty() || endian == "native") &&
                                          std::endian::native == std::endian::big);
  XdmfStored stored;
  stored.dims = xdmf_dims(tree_, item, tree_.attribute(item, {"Dimensions"}));
  stored.type = type;
  const std::string seek = tree_.attribute(item, {"Seek"});
  const std::int64_t offset = seek.empty() ? 0 : parse_integer(seek).value_or(-1);
  const std::shared_ptr<const ByteSource> source = open_(xdmf_binary_name(tree_, item));
  const std::int64_t num_bytes = product(stored.dims) * static_cast<std::int64_t>(size_of(type));
  if (offset < 0 || offset > source->size() || num_bytes > source->size() - offset) {
    tree_.fail(
        item, fmt::format("needs {} bytes from {} on: {} has {}", num_bytes,
                          seek.empty() ? "0" : seek.substr(0, 40), source->name(), source->size()));
  }
  const std::int64_t row_size = num_bytes / stored.dims[0];
  stored.read = [this, source, offset, row_size, type, is_big](std::int64_t first,
                                                               std::span<std::byte> out) {
    std::int64_t at = offset + first * row_size;
    for (std::span<std::byte> rest = out; !rest.empty();) {
      const std::span<std::byte> piece =
          rest.first(std::min(rest.size(), static_cast<std::size_t>(ReadProgress::kChunk)));
      source->read(at, piece);
      at += static_cast<std::int64_t>(piece.size());
      rest = rest.subspan(piece.size());
      progress_.advance(static_cast<std::int64_t>(piece.size()));
    }
    if (is_big != (std::endian::native == std::endian::big)) swap_bytes(out, size_of(type));
  };
  return stored;
}

XdmfStored XdmfItems::stored_hdf5(XdmfNode item) const {
  const XdmfHdf5Name name = xdmf_hdf5_name(tree_, item);
  const XdmfHdf5 reader = hdf5_reader;
  if (reader == nullptr) tree_.refuse(item, "is HDF5, which this build does not read");
  XdmfStored stored =
      reader(fmt::format("{}: '{}'", name.file, name.path), name.file, name.path, progress_);
  const std::string text = tree_.attribute(item, {"Dimensions"});
  if (text.empty()) return stored;
  const std::vector<std::int64_t> dims = xdmf_dims(tree_, item, text);
  if (product(dims) != product(stored.dims)) {
    tree_.fail(item, fmt::format("has Dimensions {}: '{}' in {} has {}", fmt::join(dims, " "),
                                 name.path, name.file, fmt::join(stored.dims, " ")));
  }
  return stored;
}

XdmfStored XdmfItems::stored(XdmfNode item) const {
  const std::string kind = item_kind(tree_, item), format = item_format(tree_, item);
  if (kind != "uniform") {
    tree_.refuse(item, fmt::format("is of ItemType {}, which is not read: expected numbers or a "
                                   "HyperSlab of numbers, or a Function JOIN($0, $1, ...)",
                                   kind.substr(0, 40)));
  }
  if (is_xdmf_hdf5(tree_, item)) return stored_hdf5(item);
  if (format == "binary") return stored_binary(item, item_type(tree_, item));
  if (format == "xml") return stored_text(item, item_type(tree_, item));
  tree_.refuse(item, fmt::format("has Format '{}', which is not read: expected XML, HDF or Binary",
                                 format.substr(0, 40)));
}

XdmfNumbers XdmfItems::read_rows(XdmfNode item, const XdmfStored& stored, std::int64_t first,
                                 std::int64_t count) const {
  XdmfNumbers numbers{stored.dims, stored.type, {}};
  numbers.dims[0] = count;
  const std::int64_t num_bytes = checked_num_bytes(
      fmt::format("{}: {}", tree_.source().name(), tree_.where(item)), numbers.dims, stored.type);
  SampleBuffer buffer;
  const std::span<std::byte> out = buffer.extend(num_bytes, num_bytes);
  stored.read(first, out);
  numbers.bytes = buffer.release();
  return numbers;
}

// Start, stride and count of each axis of the second item, as numbers of the first.
XdmfNumbers XdmfItems::read_slab(XdmfNode item, int depth) const {
  const std::vector<XdmfNode> items = tree_.children(item, "DataItem");
  if (items.size() != 2)
    tree_.fail(item, "is a HyperSlab: expected two DataItems, what is taken and of what");
  const XdmfNumbers choice = read_at(items[0], depth + 1);
  const XdmfStored source = stored(items[1]);
  // The source's axes as the XDMF states them, which may be others than the file's.
  const std::string text = tree_.attribute(items[1], {"Dimensions"});
  const std::vector<std::int64_t> dims =
      text.empty() ? source.dims : xdmf_dims(tree_, items[1], text);
  XdmfSlab slab = slab_of(tree_, item, choice, dims);
  // Only rows of the slowest axis that are needed, where the file has it.
  const bool is_same = source.dims == dims && item_format(tree_, items[1]) != "xml";
  const std::int64_t first = is_same ? slab.start[0] : 0;
  const std::int64_t num_rows = is_same ? (slab.count[0] - 1) * slab.stride[0] + 1 : source.dims[0];
  XdmfNumbers rows = read_rows(items[1], source, first, num_rows);
  slab.start[0] -= first;
  if (slab.is_all_of(rows, dims)) {
    rows.dims = std::move(slab.count);
    return rows;
  }
  return taken_from(rows, slab, dims);
}

// Components side by side, each from an item of its own.
XdmfNumbers XdmfItems::read_join(XdmfNode item, int depth) const {
  const std::vector<XdmfNode> items = tree_.children(item, "DataItem");
  std::vector<XdmfNumbers> parts;
  parts.reserve(items.size());
  for (const XdmfNode one : items) {
    parts.push_back(read_at(one, depth + 1));
    if (parts.back().count() == parts[0].count() && parts.back().type == parts[0].type) continue;
    tree_.fail(item, fmt::format("joins {} numbers of {} and {} of {}", parts[0].count(),
                                 name_of(parts[0].type), parts.back().count(),
                                 name_of(parts.back().type)));
  }
  const std::size_t size = size_of(parts[0].type);
  const auto num_parts = static_cast<std::int64_t>(parts.size());
  XdmfNumbers joined{parts[0].dims, parts[0].type, {}};
  joined.dims.push_back(num_parts);
  const std::int64_t num_bytes = parts[0].count() * num_parts * static_cast<std::int64_t>(size);
  SampleBuffer buffer;
  std::byte* out = buffer.extend(num_bytes, num_bytes).data();
  for (std::size_t i = 0; i < static_cast<std::size_t>(parts[0].count()); ++i) {
    for (const XdmfNumbers& part : parts) {
      std::memcpy(out, part.bytes.view.data() + i * size, size);
      out += size;
    }
  }
  joined.bytes = buffer.release();
  return joined;
}

XdmfNumbers XdmfItems::read_at(XdmfNode item, int depth) const {
  constexpr int kDeepest = 8;
  if (depth > kDeepest) tree_.refuse(item, "is made of items that are made of items, and so on");
  const std::string text = tree_.attribute(item, {"Dimensions"});
  XdmfNumbers numbers;
  if (item_kind(tree_, item) == "hyperslab") {
    numbers = read_slab(item, depth);
  } else if (item_kind(tree_, item) == "function" && !is_xdmf_formula(tree_, item)) {
    numbers = read_join(item, depth);
  } else {
    const XdmfStored array = stored(item);
    numbers = read_rows(item, array, 0, array.dims[0]);
  }
  if (text.empty()) return numbers;
  std::vector<std::int64_t> dims = xdmf_dims(tree_, item, text);
  if (product(dims) != numbers.count()) {
    tree_.fail(item, fmt::format("has Dimensions {}: {} numbers are taken", fmt::join(dims, " "),
                                 numbers.count()));
  }
  numbers.dims = std::move(dims);
  return numbers;
}

}  // namespace ovoid::io
