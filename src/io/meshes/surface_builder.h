// SPDX-License-Identifier: Apache-2.0
// The mesh of a file of triangles, lines and points, while these come in.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "data/cell_builder.h"
#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/dataset.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {

class SurfaceBuilder {
 public:
  std::int64_t num_nodes() const noexcept { return static_cast<std::int64_t>(places_.size() / 3); }
  void add_node(const std::array<double, 3>& at) {
    for (const double x : at) places_.push_back(static_cast<float>(x));
  }
  // Fans of polygons.
  void add_face(const std::vector<std::uint32_t>& nodes) {
    for (std::size_t i = 2; i < nodes.size(); ++i)
      cells_.add(CellType::kTriangle, std::array{nodes[0], nodes[i - 1], nodes[i]});
  }
  void add_line(const std::vector<std::uint32_t>& nodes) { cells_.add(CellType::kPolyLine, nodes); }
  void add_point(std::uint32_t node) { cells_.add(CellType::kVertex, std::array{node}); }

  // Throws Error(kFileFormat) if nothing has come in.
  Dataset finish(const ByteSource& source, const char* format, const ReadOptions& options) && {
    if (cells_.types.empty())
      throw Error(ErrorCode::kFileFormat, source.name() + ": has no faces or lines");
    Dataset dataset;
    dataset.source = source.name();
    dataset.format = format;
    std::vector<MeshPart> parts(1);
    MeshPart& part = parts.front();
    part.positions.num_tuples = num_nodes();
    part.positions.num_components = 3;
    part.positions.bytes = bytes_owning(std::move(places_));
    part.cells = std::move(cells_).finish();
    ReadOptions of_faces = options;
    of_faces.faces = true;
    return mesh_of_parts(std::move(dataset), std::move(parts), of_faces);
  }

 private:
  std::vector<float> places_;
  data::CellBuilder cells_;
};

}  // namespace ovoid::io
