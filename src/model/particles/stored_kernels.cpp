// SPDX-License-Identifier: Apache-2.0
// Kernels as files hold them, sigmas and a quaternion, to and from the factor of the covariance.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "data/kernels/kernel_shape.h"
#include "data/parallel.h"
#include "data/validate.h"
#include "model/mesh/ellipsoid_shape.h"
#include "model/own_array.h"
#include "model/particles/kernel_parts.h"
#include "model/team/team_run.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"

namespace ovoid {

namespace model {

namespace {

constexpr double kStoredCutoff = 4;

[[noreturn]] void refuse_kernel(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

bool is_shape_array(const std::string& name) {
  return name == "scale" || name == "rotation" || name == "weight";
}

const DataArray& stored_array(const ModelRun& run, const char* name, int components) {
  for (const DataArray& array : run.dataset.arrays) {
    if (array.name != name) continue;
    if (array.num_components == components) return array;
    refuse_kernel(fmt::format("array '{}': {} components, must be {}", name, array.num_components,
                              components));
  }
  refuse_kernel(fmt::format("'{}': stored kernels need an array '{}'", run.dataset.source, name));
}

// Opacity's array: the one asked for, else "value", else the first that is not part of the shape.
// Kernels without any have the value 1.
SiteValues stored_values(const ModelRun& run) {
  const std::int64_t count = run.dataset.num_positions();
  if (!run.options.array.empty()) return load_values(run, choose_arrays(run), count, "kernels");
  const DataArray* first = nullptr;
  for (const DataArray& array : run.dataset.arrays) {
    if (is_shape_array(array.name)) continue;
    if (first == nullptr || array.name == "value") first = &array;
  }
  ChosenArrays chosen;
  run.report.array = run.report.color_array = first != nullptr ? first->name : "value";
  if (first != nullptr) chosen.arrays.push_back(first);
  if (!run.options.color_array.empty() && run.options.color_array != run.report.array) {
    chosen.arrays.push_back(&run.dataset.array(run.options.color_array));
    run.report.color_array = run.options.color_array;
  }
  SiteValues values = load_values(run, chosen, count, "kernels");
  if (first != nullptr) return values;
  values.columns.emplace(values.columns.begin(), static_cast<std::size_t>(count), 1.0F);
  values.attributes.insert(values.attributes.begin(), {"value", "", {}});
  run.report.notes.emplace_back("the kernels have no values; each has the value 1");
  return values;
}

Mat3 factor_of_kernel(const double* scale, const double* rotation, std::size_t row) {
  for (int a = 0; a < 3; ++a) {
    if (!(scale[a] > 0) || !std::isfinite(scale[a]))
      refuse_kernel(fmt::format("scale[{}][{}] = {}: must be > 0", row, a, scale[a]));
  }
  const Eigen::Vector4d numbers(rotation[0], rotation[1], rotation[2], rotation[3]);
  const double norm = numbers.stableNorm();
  if (!(norm > 0) || !std::isfinite(norm))
    refuse_kernel(fmt::format("rotation[{}] = {} {} {} {}: must be a quaternion w x y z, not 0",
                              row, numbers[0], numbers[1], numbers[2], numbers[3]));
  const Eigen::Vector4d q = numbers / norm;
  const Mat3 axes = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  return factor_of_axes(axes, {scale[0], scale[1], scale[2]});
}

}  // namespace

KernelParts stored_kernels(const ModelRun& run) {
  const SiteValues values = stored_values(run);
  const std::vector<double> centers = load_positions(run);
  const std::int64_t count = run.dataset.num_positions();
  const std::vector<double> scales =
      load_tuples(stored_array(run, "scale", 3), count, 3, "kernels");
  const std::vector<double> rotations =
      load_tuples(stored_array(run, "rotation", 4), count, 4, "kernels");
  std::vector<float> weights;
  for (const DataArray& array : run.dataset.arrays) {
    if (array.name == "weight") weights = load_column(run, array, count, "kernels");
  }
  KernelParts parts;
  parts.shape = KernelShape::kEllipsoids;
  parts.cutoff = run.options.cutoff.value_or(run.dataset.cutoff.value_or(kStoredCutoff));
  parts.reconstruction = run.options.reconstruction.value_or(
      run.dataset.reconstruction.value_or(Reconstruction::kSum));
  parts.attributes = values.attributes;
  run.report.num_sites = count;
  const std::int64_t first_row = run.dataset.share ? run.dataset.share->first : 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const auto row = static_cast<std::size_t>(first_row) + i;
    const Mat3 factor = factor_of_kernel(scales.data() + 3 * i, rotations.data() + 4 * i, row);
    if (!weights.empty() && (!(weights[i] > 0) || !std::isfinite(weights[i])))
      refuse_kernel(fmt::format("weight[{}] = {}: must be > 0", row, weights[i]));
    const Vec3 center(centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]);
    if (!center.allFinite()) {
      ++run.report.num_misplaced;
      continue;
    }
    if (!values.is_finite(i)) {
      ++run.report.num_missing;
      continue;
    }
    append_site(parts, center, values, i);
    append_factor(factor, parts.shapes);
    if (!weights.empty()) parts.weights.push_back(weights[i]);
  }
  if (total_of(run, static_cast<std::int64_t>(parts.count())) == 0)
    refuse_kernel(
        fmt::format("'{}': no kernel: of {}, {} have no finite value of '{}' and {} no "
                    "finite position",
                    run.dataset.source, count, run.report.num_missing, run.report.array,
                    run.report.num_misplaced));
  if (weights.empty()) parts.weights = {1.0F};
  return parts;
}

namespace {

struct KernelTable {
  std::vector<double> positions;
  std::vector<float> scales, rotations, weights;
  std::vector<std::vector<float>> values;
};

// Whether places in single precision are off by no more than bricks' are (KernelBrick).
bool are_singles_enough(const KernelSource& source) {
  constexpr double kRounding = std::numeric_limits<float>::epsilon() / 2;
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelBrick& brick = source.brick(b);
    const double farthest = std::max(brick.support.min().cwiseAbs().maxCoeff(),
                                     brick.support.max().cwiseAbs().maxCoeff());
    const double most = KernelBrick::kMaxOffsetError * static_cast<double>(brick.least_sigma);
    if (!(kRounding * farthest <= most)) return false;
  }
  return true;
}

// Sigmas, falling, and the rotation from their axes to the world.
void append_axes(const Mat3& factor, KernelTable& table) {
  // The singular values of the factor keep the digits that its square would lose.
  const double unit = factor.cwiseAbs().maxCoeff();
  const Eigen::JacobiSVD<Mat3> decomposition(factor / unit, Eigen::ComputeFullU);
  Mat3 axes = decomposition.matrixU();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  const Eigen::Quaterniond rotation(axes);
  for (int a = 0; a < 3; ++a)
    table.scales.push_back(static_cast<float>(unit * decomposition.singularValues()[a]));
  for (const double number : {rotation.w(), rotation.x(), rotation.y(), rotation.z()})
    table.rotations.push_back(static_cast<float>(number));
}

void append_brick(const KernelSource& source, std::int64_t b, KernelTable& table) {
  const KernelView view = source.acquire(b, 0.0);
  for (std::int32_t i = 0; i < view.count; ++i) {
    const Vec3 at = source.brick(b).origin + data::offset_of(view, i);
    table.positions.insert(table.positions.end(), {at[0], at[1], at[2]});
    const auto numbers = data::shape_numbers(view, source.shape(), i);
    if (source.shape() == KernelShape::kBalls) {
      table.scales.insert(table.scales.end(), 3, numbers[0]);
      table.rotations.insert(table.rotations.end(), {1.0F, 0.0F, 0.0F, 0.0F});
    } else {
      append_axes(data::factor_of(source.shape(), numbers.data()), table);
    }
    table.weights.push_back(data::weight_of(view, i));
    for (std::size_t a = 0; a < table.values.size(); ++a)
      table.values[a].push_back(view.value[a][i]);
  }
}

}  // namespace

}  // namespace model

Dataset make_kernel_dataset(const KernelField& field) {
  data::require_field(field);
  const KernelSource& source = field.source();
  model::KernelTable table;
  table.values.resize(source.attributes().size());
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) model::append_brick(source, b, table);
  Dataset dataset;
  dataset.source = "kernels";
  dataset.format = "kernels";
  dataset.kind = DatasetKind::kKernels;
  dataset.reconstruction = field.reconstruction();
  dataset.cutoff = source.cutoff();
  if (model::are_singles_enough(source)) {
    dataset.positions = model::array_of_numbers(
        "positions", 3, std::vector<float>(table.positions.begin(), table.positions.end()));
  } else {
    dataset.positions = model::array_of_numbers("positions", 3, std::move(table.positions));
  }
  dataset.arrays.push_back(model::array_of_numbers("scale", 3, std::move(table.scales)));
  dataset.arrays.push_back(model::array_of_numbers("rotation", 4, std::move(table.rotations)));
  dataset.arrays.push_back(model::array_of_numbers("weight", 1, std::move(table.weights)));
  for (std::size_t a = 0; a < table.values.size(); ++a) {
    dataset.arrays.push_back(
        model::array_of_numbers(source.attributes()[a].name, 1, std::move(table.values[a])));
    dataset.arrays.back().unit = source.attributes()[a].unit;
  }
  return dataset;
}

std::int64_t kernel_file_bytes(const KernelField& field, std::int64_t num_kernels) {
  data::require_field(field);
  // Header: the format's words, and a line for each column.
  constexpr std::int64_t kHeaderBytes = 512, kLineBytes = 32;
  constexpr std::int64_t kShapeAndWeight = 8 * sizeof(float);
  const std::size_t place =
      model::are_singles_enough(field.source()) ? sizeof(float) : sizeof(double);
  std::int64_t header = kHeaderBytes,
               record = kShapeAndWeight + 3 * static_cast<std::int64_t>(place);
  for (const KernelAttribute& attribute : field.source().attributes()) {
    header += kLineBytes + static_cast<std::int64_t>(attribute.name.size());
    record += static_cast<std::int64_t>(sizeof(float));
  }
  return header + num_kernels * record;
}

}  // namespace ovoid
