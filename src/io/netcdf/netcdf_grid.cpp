// SPDX-License-Identifier: Apache-2.0
#include "io/netcdf/netcdf_grid.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/core/cf_grid.h"
#include "io/core/cf_places.h"
#include "io/meshes/mesh_files.h"
#include "io/netcdf/netcdf_header.h"

namespace ovoid::io {
namespace {

class ClassicFile final : public CfFile {
 public:
  explicit ClassicFile(const ByteSource& source)
      : CfFile(source.name()), source_(source), header_(read_netcdf_header(source)) {}

  const CfDescription& description() const override { return header_; }
  std::vector<double> numbers(const CfVariable& variable, std::int64_t most) const override {
    return netcdf_numbers(source_, header_, variable, most);
  }

  // Chunks are planes of the two axes that vary fastest; records are none of them.
  ChunkedArray array(const CfVariable& variable, bool may_stay) const override {
    const NetcdfPlace& place = header_.place_of(variable);
    ChunkedArray array;
    array.shape = header_.shape(variable);
    array.type = *variable.type;
    array.is_big_endian = true;
    const std::size_t rank = array.shape.size();
    array.chunk.assign(rank, 1);
    for (std::size_t a = rank; a-- > 0 && a + 2 >= rank;)
      if (a > 0 || !place.has_records) array.chunk[a] = array.shape[a];
    // Samples that stay in the file keep it open.
    if (may_stay && own_ == nullptr) own_ = open_file(source_.name());
    const std::shared_ptr<const ByteSource> own = may_stay ? own_ : nullptr;
    array.read = [&source = source_, own, begin = place.begin,
                  stride = place.has_records ? header_.record_stride : 0, shape = array.shape,
                  chunk = array.chunk](std::span<const std::int64_t> number,
                                       std::span<std::byte> out) {
      std::int64_t plane = 0;  // its number
      for (std::size_t a = stride > 0 ? 1 : 0; a < shape.size(); ++a)
        if (chunk[a] == 1) plane = plane * shape[a] + number[a];
      const auto size = static_cast<std::int64_t>(out.size());
      const std::int64_t record = stride > 0 ? number[0] * stride : 0;
      (own ? *own : source).read(begin + record + plane * size, out);
      return true;
    };
    return array;
  }

 private:
  const ByteSource& source_;
  NetcdfHeader header_;
  mutable std::shared_ptr<const ByteSource> own_;
};

}  // namespace

bool is_netcdf_grid(const ByteSource& source, std::string_view start) {
  return begins_like_netcdf(start) && !is_exodus(source, start);
}

Dataset read_netcdf_grid(const ByteSource& source, const ReadOptions& options) {
  return read_cf_grid(ClassicFile(source), options);
}

std::optional<double> time_of_netcdf(const ByteSource& source) {
  const ClassicFile file(source);
  const CfCoordinateFinder finder(file.description());
  for (const CfVariable& variable : file.description().variables) {
    const CfCoordinates coordinates = finder.of(variable);
    const CfTimes found =
        cf_times(file, cf_axes(file.description(), variable, coordinates), coordinates);
    if (found.times.size() == 1) return found.times[0];
  }
  return std::nullopt;
}

}  // namespace ovoid::io
