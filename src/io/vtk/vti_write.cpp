// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/vti_write.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "io/vtk/image_sections.h"
#include "io/vtk/xml_array_file.h"

namespace ovoid::io {
namespace {

// An axis as VTK keeps it: the vector from one sample to the next is spacing times direction.
struct ImageAxis {
  double spacing = 1;
  Vec3 direction;
};

// The factor whose product with `spacing` is `number` to the last bit, or if there is none the
// nearest. A quotient is often one bit off.
double exact_factor(double number, double spacing) {
  const double quotient = number / spacing;
  for (const double toward :
       {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    if (quotient * spacing == number) break;
    const double factor = std::nextafter(quotient, toward);
    if (factor * spacing == number) return factor;
  }
  return quotient;
}

// Readers multiply, and the axis should come back as it is: not every length has factors for all
// three of its numbers, but one of the next few has.
ImageAxis image_axis(const Vec3& step) {
  constexpr int kMostTries = 64;
  ImageAxis axis{step.norm(), {}};
  ImageAxis tried = axis;
  for (int i = 0; i < kMostTries; ++i) {
    for (int row = 0; row < 3; ++row) tried.direction[row] = exact_factor(step[row], tried.spacing);
    if (i == 0) axis = tried;
    if (Vec3(tried.direction * tried.spacing) == step) return tried;
    tried.spacing = std::nextafter(tried.spacing, std::numeric_limits<double>::infinity());
  }
  return axis;
}

void add_section(XmlArrayFile& file, const ImageSection& chosen, const char* section) {
  // Our own check of the header takes references in names alone.
  const std::string scalars = chosen.scalars == nullptr ? "" : xml_text(chosen.scalars->name);
  const bool is_named = !scalars.empty() && scalars.find('&') == std::string::npos;
  file.text(fmt::format("      <{}{}>\n", section,
                        is_named ? fmt::format(" Scalars=\"{}\"", scalars) : ""));
  for (const DataArray* const array : chosen.arrays) file.array(*array);
  file.text(fmt::format("      </{}>\n", section));
}

}  // namespace

void write_vti(const Dataset& dataset, const std::string& path, const std::stop_token& stop) {
  const Index3& dims = dataset.lattice.dims;
  const ImageSections sections = image_sections(dataset, path);
  const Affine3& place = dataset.lattice.world_from_index;
  const ImageAxis axes[] = {image_axis(place.linear().col(0)), image_axis(place.linear().col(1)),
                            image_axis(place.linear().col(2))};
  std::string directions;  // row by row
  for (int row = 0; row < 3; ++row) {
    for (const ImageAxis& axis : axes)
      directions += fmt::format("{}{}", directions.empty() ? "" : " ", axis.direction[row]);
  }
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", dims[0] - 1, dims[1] - 1, dims[2] - 1);
  const Vec3 origin = place.translation();
  XmlArrayFile file("ImageData", XmlArrayFile::Packing::kZlib);
  file.text(
      fmt::format("  <ImageData WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\" "
                  "Direction=\"{}\">\n    <Piece Extent=\"{}\">\n",
                  extent, origin[0], origin[1], origin[2], axes[0].spacing, axes[1].spacing,
                  axes[2].spacing, directions, extent));
  add_section(file, sections.of_points, "PointData");
  add_section(file, sections.of_cells, "CellData");
  file.text("    </Piece>\n  </ImageData>\n");
  file.write(path, stop);
}

}  // namespace ovoid::io
