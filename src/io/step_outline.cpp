// SPDX-License-Identifier: Apache-2.0
#include "io/step_outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "io/core/byte_source.h"
#include "io/core/byte_stream.h"
#include "io/core/samples.h"
#include "io/core/text_file.h"
#include "io/core/text_scanner.h"
#include "io/core/xml_tags.h"
#include "io/formats.h"
#include "io/images/metaimage_header.h"
#include "io/images/nifti_header.h"
#include "io/images/npy_header.h"
#include "io/images/nrrd_header.h"
#include "ovoid/dataset.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Kinds = std::vector<DatasetKind>;

const Kinds kLatticeOnly{DatasetKind::kLattice};
const Kinds kParticlesOnly{DatasetKind::kParticles};
const Kinds kMeshOrParticles{DatasetKind::kMesh, DatasetKind::kParticles};
const Kinds kLatticeOrMesh{DatasetKind::kLattice, DatasetKind::kMesh};

std::vector<double> reals(std::string_view text) {
  std::vector<double> result;
  for (const std::string_view word : words(text)) result.push_back(parse_real(word).value_or(0));
  return result;
}

}  // namespace

StepOutline outline_of_nrrd(const ByteSource& source) {
  StepOutline outline{kLatticeOnly, {}, {}};
  for (const NrrdAxis& axis : read_nrrd_header(source).axes) {
    outline.sizes.push_back(axis.size);
    if (axis.direction)
      outline.spacings.insert(outline.spacings.end(), axis.direction->begin(),
                              axis.direction->end());
    else if (axis.spacing)
      outline.spacings.push_back(*axis.spacing);
  }
  return outline;
}

StepOutline outline_of_nifti(const ByteSource& source) {
  const NiftiHeader header = parse_nifti_header(source.name(), stream_start(source, kNifti2Size));
  return {kLatticeOnly,
          {header.dims.begin(), header.dims.begin() + 3},
          {header.pixdim.begin() + 1, header.pixdim.begin() + 4}};
}

StepOutline outline_of_metaimage(const ByteSource& source) {
  const MetaImageHeader header = read_metaimage_header(source);
  return {kLatticeOnly, header.sizes, header.spacing};
}

// Of two axes it may be positions, of which every step may have its own number.
StepOutline outline_of_npy(const ByteSource& source) {
  const NpyHeader header = read_npy_header(source);
  if (header.shape.size() < 3) return {};
  return {kLatticeOnly, header.shape, {}};
}

StepOutline outline_of_vtk_xml(const ByteSource& source) {
  XmlTagReader reader(source);
  constexpr int kMostTags = 8;  // the image's is the second or third
  std::string type;
  for (int i = 0; i < kMostTags; ++i) {
    const auto tag = reader.next();
    if (!tag) return {};
    if (tag->name == "VTKFile") type = tag->attribute("type");
    if (type == "UnstructuredGrid") return {kMeshOrParticles, {}, {}};
    if (type == "StructuredGrid") return {{DatasetKind::kMesh}, {}, {}};
    if (type == "PolyData") return {kParticlesOnly, {}, {}};
    if (type.empty() || tag->name != type) continue;
    StepOutline outline{type == "ImageData" ? kLatticeOnly : kLatticeOrMesh, {}, {}};
    const std::vector<double> extent = reals(tag->attribute("WholeExtent"));
    for (std::size_t axis = 0; axis + 1 < extent.size(); axis += 2)
      outline.sizes.push_back(static_cast<std::int64_t>(extent[axis + 1] - extent[axis]) + 1);
    if (type == "ImageData") outline.spacings = reals(tag->attribute("Spacing"));
    return outline;
  }
  return {};
}

StepOutline outline_of_legacy_vtk(const ByteSource& source) {
  TextScanner text(source, 0, source.size());
  StepOutline outline;
  constexpr int kMostWords = 64;  // the title's among them
  text.line();
  text.line();
  std::string before;
  for (int i = 0; i < kMostWords; ++i) {
    const std::string word = lower(text.word());
    if (before == "dataset") {
      outline.kinds = word == "structured_points"   ? kLatticeOnly
                      : word == "rectilinear_grid"  ? kLatticeOrMesh
                      : word == "structured_grid"   ? Kinds{DatasetKind::kMesh}
                      : word == "unstructured_grid" ? kMeshOrParticles
                      : word == "polydata"          ? kParticlesOnly
                                                    : Kinds{};
      if (outline.kinds != kLatticeOnly) return outline;
    }
    if (word == "dimensions") {
      for (int axis = 0; axis < 3; ++axis)
        outline.sizes.push_back(parse_integer(text.word()).value_or(0));
    }
    if (word == "spacing") {
      for (int axis = 0; axis < 3; ++axis)
        outline.spacings.push_back(parse_real(text.word()).value_or(0));
    }
    if (word.empty() || word == "point_data" || word == "cell_data") break;
    before = word;
  }
  return outline;
}

namespace {

StepOutline outline_of(const ByteSource& source) {
  const Format* const format = format_of(source, {});
  if (format == nullptr) return {};
  return format->outline != nullptr ? format->outline(source) : StepOutline{format->kinds, {}, {}};
}

// What is broken, or not there, is told by who reads it.
StepOutline outline_if_any(const std::string& path) {
  try {
    return outline_of(*open_file(path));
  } catch (const Error&) {
    return {};
  }
}

bool may_be_one(const Kinds& a, const Kinds& b) {
  return a.empty() || b.empty() || std::any_of(a.begin(), a.end(), [&](DatasetKind kind) {
           return std::find(b.begin(), b.end(), kind) != b.end();
         });
}

// As far as Series takes them for the same.
bool are_same_spacings(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double kSame = 1e-3;
  double greatest = 0;
  for (const double spacing : a) greatest = std::max(greatest, std::abs(spacing));
  return a.size() != b.size() ||  // said in another way
         std::equal(a.begin(), a.end(), b.begin(),
                    [&](double x, double y) { return std::abs(x - y) <= kSame * greatest; });
}

std::string difference(const StepOutline& a, const std::string& first, const StepOutline& b) {
  if (!may_be_one(a.kinds, b.kinds))
    return fmt::format("holds {}, {} {}", name_of(b.kinds[0]), first, name_of(a.kinds[0]));
  const bool has_sizes = !a.sizes.empty() && a.sizes.size() == b.sizes.size();
  if (has_sizes && a.sizes != b.sizes)
    return fmt::format("is {}, {} is {}", dims_text(b.sizes), first, dims_text(a.sizes));
  if (has_sizes && !are_same_spacings(a.spacings, b.spacings)) {
    return fmt::format("has spacings {}, {} has {}", fmt::join(b.spacings, " "), first,
                       fmt::join(a.spacings, " "));
  }
  return {};
}

}  // namespace

void check_step_outlines(const std::string& first, const std::vector<std::string>& others) {
  const StepOutline outline = outline_if_any(first);
  for (const std::string& path : others) {
    const std::string what = difference(outline, first, outline_if_any(path));
    if (what.empty()) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: {}: several inputs are steps of one dataset, alike in kind, "
                            "dimensions and spacing",
                            path, what));
  }
}

}  // namespace ovoid::io
