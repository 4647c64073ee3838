// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

#include "data/out_of_memory.h"
#include "io/core/atomic_file.h"
#include "io/core/signatures.h"
#include "io/images/nifti.h"
#include "io/images/nifti_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;

// A file, or gzip data into one.
class OutputStream {
 public:
  OutputStream(const std::string& path, const std::stop_token& stop)
      : file_(path, stop), is_gzip_(ending_of(path) == ".nii.gz") {
    constexpr int kGzipHeader = 16;
    constexpr int kDefaultMemory = 8;
    if (is_gzip_ && deflateInit2(&stream_, kLevel, Z_DEFLATED, 15 + kGzipHeader, kDefaultMemory,
                                 Z_DEFAULT_STRATEGY) != Z_OK) {
      constexpr std::size_t kMemory = 264 << 10;  // of zlib's manual, with these parameters
      data::throw_out_of_memory("zlib", kMemory);
    }
  }
  ~OutputStream() {
    if (is_gzip_) deflateEnd(&stream_);
  }
  OutputStream(const OutputStream&) = delete;
  OutputStream& operator=(const OutputStream&) = delete;

  void write(const std::byte* data, std::size_t size) {
    if (!is_gzip_) return file_.write(data, size);
    while (size > 0) {
      const std::size_t count = std::min(size, kChunk);
      deflate_all(data, count, Z_NO_FLUSH);
      data += count;
      size -= count;
    }
  }

  void commit() {
    if (is_gzip_) deflate_all(nullptr, 0, Z_FINISH);
    file_.commit();
  }

 private:
  static constexpr int kLevel = 6;  // gzip's own

  void deflate_all(const std::byte* data, std::size_t size, int flush) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(data));
    stream_.avail_in = static_cast<uInt>(size);
    do {
      stream_.next_out = packed_.data();
      stream_.avail_out = static_cast<uInt>(packed_.size());
      deflate(&stream_, flush);  // cannot fail with room and a stream that was set up
      file_.write(packed_.data(), packed_.size() - stream_.avail_out);
    } while (stream_.avail_out == 0);
  }

  AtomicFile file_;
  bool is_gzip_;
  z_stream stream_{};
  std::vector<Bytef> packed_ = std::vector<Bytef>(kChunk);
};

// What the header says of a lattice in RAS.
struct Placement {
  Vec3 spacing;
  Affine3 sform;
  int code = 0;            // of sform, and of qform if there is one
  bool has_qform = false;  // the axes are orthogonal
  double qfac = 1;
  Vec3 quaternion = Vec3::Zero();  // b c d
};

Placement placement_of(const Dataset& dataset) {
  constexpr int kScanner = 1, kAligned = 2;
  Placement result;
  result.spacing = dataset.lattice.spacing();
  result.sform = dataset.lattice.world_from_index;
  result.code = dataset.space == Space::kNone ? kAligned : kScanner;
  if (dataset.space == Space::kNone && is_placed_by_spacing(dataset.lattice)) result.code = 0;
  if (dataset.space == Space::kLps)
    result.sform.matrix().topRows<2>() *= -1;  // right is not left, anterior not posterior
  Mat3 rotation = result.sform.linear().array().rowwise() / result.spacing.transpose().array();
  // Readers compare the two: a qform that is only nearly the same would be a contradiction.
  constexpr double kOrthogonal = 1e-6;
  result.has_qform = result.code > 0 && (rotation.transpose() * rotation).isIdentity(kOrthogonal);
  if (rotation.determinant() < 0) {
    result.qfac = -1;
    rotation.col(2) *= -1;
  }
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() *= -1;
  if (result.has_qform) result.quaternion = q.vec();
  return result;
}

bool fits_float(double value) {
  const double size = std::abs(value);
  return size == 0 ||
         (size >= std::numeric_limits<float>::min() && size <= std::numeric_limits<float>::max());
}

bool fits_version_1(const Dataset& dataset, const DataArray& array, const Placement& placement) {
  constexpr std::int64_t kLongest = std::numeric_limits<std::int16_t>::max();
  const Index3& dims = dataset.lattice.dims;
  bool fits = *std::max_element(dims.begin(), dims.end()) <= kLongest &&
              array.num_components <= kLongest && fits_float(array.value_scale) &&
              fits_float(array.value_offset);
  for (Eigen::Index row = 0; row < 3; ++row) {
    fits = fits && fits_float(placement.spacing[row]);
    for (Eigen::Index column = 0; column < 4; ++column)
      fits = fits && fits_float(placement.sform(row, column));
  }
  return fits;
}

// Bytes of a header at places that the format gives, native order. Numbers that both versions have
// are `Real` in width: float or double.
class HeaderBytes {
 public:
  explicit HeaderBytes(std::size_t size) : bytes_(size) {}

  template <typename T>
  void put(std::size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof(T));
  }
  template <typename T, typename Numbers>
  void put_all(std::size_t offset, const Numbers& numbers) {
    for (const auto number : numbers) {
      put(offset, static_cast<T>(number));
      offset += sizeof(T);
    }
  }
  // Cut to leave a zero at the end.
  void put_text(std::size_t offset, std::size_t size, std::string_view text) {
    text = text.substr(0, size - 1);
    if (!text.empty()) std::memcpy(bytes_.data() + offset, text.data(), text.size());
  }

  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

std::array<std::int64_t, 8> dims_of(const Dataset& dataset, const DataArray& array) {
  const Index3& dims = dataset.lattice.dims;
  const std::int64_t num_axes = array.num_components > 1 ? 5 : 3;
  return {num_axes, dims[0], dims[1], dims[2], 1, array.num_components, 1, 1};
}

// pixdim: no reader should find a step of 0 along an axis.
std::array<double, 8> steps_of(const Placement& placement) {
  const Vec3& spacing = placement.spacing;
  return {placement.qfac, spacing[0], spacing[1], spacing[2], 1, 1, 1, 1};
}

constexpr int kVectorIntent = 1007;
constexpr int kMillimetres = 2;
constexpr std::string_view kWrittenBy = "written by Ovoid";

std::string_view intent_name(const DataArray& array) {
  return array.name == "values" ? std::string_view() : std::string_view(array.name);
}

template <typename Real>
void put_placement(HeaderBytes& header, const Placement& placement, std::size_t quaternion,
                   std::size_t sform) {
  header.put_all<Real>(quaternion, placement.quaternion);
  if (placement.has_qform)
    header.put_all<Real>(quaternion + 3 * sizeof(Real), Vec3(placement.sform.translation()));
  if (placement.code == 0) return;
  for (Eigen::Index row = 0; row < 3; ++row)
    header.put_all<Real>(sform + static_cast<std::size_t>(row) * 4 * sizeof(Real),
                         Eigen::Vector4d(placement.sform.matrix().row(row)));
}

std::vector<std::byte> header_1(const Dataset& dataset, const DataArray& array,
                                const Placement& placement) {
  HeaderBytes header(kNifti1Size + kNiftiExtenderSize);
  header.put(0, static_cast<std::int32_t>(kNifti1Size));
  header.put(38, 'r');
  header.put_all<std::int16_t>(40, dims_of(dataset, array));
  header.put(68, static_cast<std::int16_t>(array.num_components > 1 ? kVectorIntent : 0));
  header.put(70, static_cast<std::int16_t>(nifti_code_of(array.type)));
  header.put(72, static_cast<std::int16_t>(8 * size_of(array.type)));
  header.put_all<float>(76, steps_of(placement));
  header.put(108, static_cast<float>(kNifti1Size + kNiftiExtenderSize));
  header.put(112, static_cast<float>(array.value_scale));
  header.put(116, static_cast<float>(array.value_offset));
  header.put(123, static_cast<char>(dataset.space == Space::kNone ? 0 : kMillimetres));
  header.put_text(148, 80, kWrittenBy);
  header.put(252, static_cast<std::int16_t>(placement.has_qform ? placement.code : 0));
  header.put(254, static_cast<std::int16_t>(placement.code));
  put_placement<float>(header, placement, 256, 280);
  header.put_text(328, 16, intent_name(array));
  header.put_text(344, 4, "n+1");
  return header.bytes();
}

std::vector<std::byte> header_2(const Dataset& dataset, const DataArray& array,
                                const Placement& placement) {
  HeaderBytes header(kNifti2Size + kNiftiExtenderSize);
  header.put(0, static_cast<std::int32_t>(kNifti2Size));
  header.put_all<char>(4, std::string_view("n+2\0\r\n\x1a\n", 8));
  header.put(12, static_cast<std::int16_t>(nifti_code_of(array.type)));
  header.put(14, static_cast<std::int16_t>(8 * size_of(array.type)));
  header.put_all<std::int64_t>(16, dims_of(dataset, array));
  header.put_all<double>(104, steps_of(placement));
  header.put(168, static_cast<std::int64_t>(kNifti2Size + kNiftiExtenderSize));
  header.put(176, array.value_scale);
  header.put(184, array.value_offset);
  header.put_text(240, 80, kWrittenBy);
  header.put(344, static_cast<std::int32_t>(placement.has_qform ? placement.code : 0));
  header.put(348, static_cast<std::int32_t>(placement.code));
  put_placement<double>(header, placement, 352, 400);
  header.put(500, static_cast<std::int32_t>(dataset.space == Space::kNone ? 0 : kMillimetres));
  header.put(504, static_cast<std::int32_t>(array.num_components > 1 ? kVectorIntent : 0));
  header.put_text(508, 16, intent_name(array));
  return header.bytes();
}

// Component after component, as the format has them.
void write_planar(const DataArray& array, OutputStream& out) {
  const std::size_t sample_size = size_of(array.type);
  const auto num_components = static_cast<std::size_t>(array.num_components);
  const std::size_t chunk_tuples = kChunk / sample_size;
  const auto num_tuples = static_cast<std::size_t>(array.num_tuples);
  std::vector<std::byte> chunk(kChunk);
  for (std::size_t c = 0; c < num_components; ++c) {
    for (std::size_t begin = 0; begin < num_tuples; begin += chunk_tuples) {
      const std::size_t count = std::min(chunk_tuples, num_tuples - begin);
      for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(chunk.data() + i * sample_size,
                    array.bytes.view.data() + ((begin + i) * num_components + c) * sample_size,
                    sample_size);
      }
      out.write(chunk.data(), count * sample_size);
    }
  }
}

}  // namespace

bool is_placed_by_spacing(const LatticeGeometry& lattice) {
  const Mat3 linear = lattice.world_from_index.linear();
  const Mat3 diagonal = linear.diagonal().asDiagonal();
  return linear == diagonal && (linear.diagonal().array() > 0).all() &&
         lattice.world_from_index.translation().isZero(0);
}

void write_nifti(const Dataset& dataset, const DataArray& array, const std::string& path,
                 const std::stop_token& stop) {
  const Placement placement = placement_of(dataset);
  const std::vector<std::byte> header = fits_version_1(dataset, array, placement)
                                            ? header_1(dataset, array, placement)
                                            : header_2(dataset, array, placement);
  OutputStream out(path, stop);
  out.write(header.data(), header.size());
  if (array.num_components > 1)
    write_planar(array, out);
  else
    out.write(array.bytes.view.data(), array.bytes.view.size());
  out.commit();
}

}  // namespace ovoid::io
