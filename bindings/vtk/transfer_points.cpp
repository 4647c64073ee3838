// SPDX-License-Identifier: Apache-2.0
// The nodes of VTK's functions as the library's points.

#include <vtkColorTransferFunction.h>
#include <vtkDiscretizableColorTransferFunction.h>
#include <vtkPiecewiseFunction.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "property_look.h"

namespace ovoid::mappers {
namespace {

constexpr double kMiddle = 0.5;  // of a node's midpoint: straight to the next

// A node of vtkColorTransferFunction: x, r, g, b, midpoint, sharpness.
using ColorNode = std::array<double, 6>;

std::vector<ColorNode> nodes_of(vtkColorTransferFunction* function) {
  std::vector<ColorNode> nodes(static_cast<std::size_t>(function->GetSize()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    function->GetNodeValue(static_cast<int>(i), nodes[i].data());
  return nodes;
}

std::optional<ColorSpace> color_space_of(vtkColorTransferFunction* function) {
  switch (function->GetColorSpace()) {
    case VTK_CTF_RGB:
      return ColorSpace::kRgb;
    case VTK_CTF_HSV:
      return function->GetHSVWrap() != 0 ? ColorSpace::kHsvWrap : ColorSpace::kHsv;
    case VTK_CTF_LAB:
      return ColorSpace::kLab;
    case VTK_CTF_DIVERGING:
      return ColorSpace::kDiverging;
    case VTK_CTF_STEP:
      return ColorSpace::kStep;
    default:
      return std::nullopt;
  }
}

bool goes_straight(const std::vector<ColorNode>& nodes) {
  return std::all_of(nodes.begin(), nodes.end(),
                     [](const ColorNode& node) { return node[4] == kMiddle && node[5] == 0; });
}

// Whether VTK's way from node to node is the library's, too.
bool is_plain(vtkColorTransferFunction* function, const std::vector<ColorNode>& nodes) {
  auto* const steps = vtkDiscretizableColorTransferFunction::SafeDownCast(function);
  return color_space_of(function) && function->GetScale() == VTK_CTF_LINEAR &&
         goes_straight(nodes) && (steps == nullptr || steps->GetDiscretize() == 0);
}

Rgb color_at(vtkColorTransferFunction* function, double x) {
  Rgb rgb{};
  function->GetColor(x, rgb.data());
  for (double& component : rgb) component = std::clamp(component, 0.0, 1.0);
  return rgb;
}

// Values between the nodes, where the function is what VTK says it is.
template <typename Nodes, typename At>
void for_each_place(const Nodes& nodes, At at) {
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double from = nodes[i][0], to = nodes[i + 1][0];
    for (int step = 0; step < kSubdivisions; ++step) at(from + (to - from) * step / kSubdivisions);
  }
  if (!nodes.empty()) at(nodes.back()[0]);
}

}  // namespace

void take_colors(vtkColorTransferFunction* function, TransferFunction* tf) {
  const std::vector<ColorNode> nodes = nodes_of(function);
  tf->color_space = ColorSpace::kRgb;
  if (is_plain(function, nodes)) {
    tf->color_space = *color_space_of(function);
    for (const ColorNode& node : nodes) {
      Rgb rgb{node[1], node[2], node[3]};
      for (double& component : rgb) component = std::clamp(component, 0.0, 1.0);
      tf->colors.push_back({node[0], rgb});
    }
  } else {
    for_each_place(nodes, [&](double x) { tf->colors.push_back({x, color_at(function, x)}); });
  }
  if (nodes.empty()) tf->colors.push_back({0, {0, 0, 0}});  // VTK's answer, black
  const Rgb black{0, 0, 0};
  if (function->GetClamping() == 0) tf->below_color = tf->above_color = black;
  if (function->GetUseBelowRangeColor() != 0) {
    const double* const rgb = function->GetBelowRangeColor();
    tf->below_color = Rgb{rgb[0], rgb[1], rgb[2]};
  }
  if (function->GetUseAboveRangeColor() != 0) {
    const double* const rgb = function->GetAboveRangeColor();
    tf->above_color = Rgb{rgb[0], rgb[1], rgb[2]};
  }
  const double* const nan = function->GetNanColor();
  tf->nan_color = {nan[0], nan[1], nan[2]};
}

void take_grays(vtkPiecewiseFunction* function, TransferFunction* tf) {
  for (const OpacityPoint& point : opacity_points(function)) {
    const bool is_straight = point.midpoint == kMiddle && point.sharpness == 0;
    tf->colors.push_back({point.x, {point.opacity, point.opacity, point.opacity}});
    if (is_straight) continue;
    double end = 0;
    for (int i = 0; i < function->GetSize() && !(end > point.x); ++i) {
      std::array<double, 4> node{};
      function->GetNodeValue(i, node.data());
      end = node[0];
    }
    for (int step = 1; step < kSubdivisions && end > point.x; ++step) {
      const double x = point.x + (end - point.x) * step / kSubdivisions;
      const double gray = std::clamp(function->GetValue(x), 0.0, 1.0);
      tf->colors.push_back({x, {gray, gray, gray}});
    }
  }
  if (tf->colors.empty()) tf->colors.push_back({0, {0, 0, 0}});
  tf->color_space = ColorSpace::kRgb;
}

std::vector<OpacityPoint> opacity_points(vtkPiecewiseFunction* function) {
  using Node = std::array<double, 4>;  // x, y, midpoint, sharpness
  std::vector<Node> nodes(static_cast<std::size_t>(function->GetSize()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    function->GetNodeValue(static_cast<int>(i), nodes[i].data());
  const bool is_log = function->GetUseLogScale();
  std::vector<OpacityPoint> points;
  const auto add = [&](double x, double opacity, double midpoint, double sharpness) {
    points.push_back({x, std::clamp(opacity, 0.0, 1.0), midpoint, sharpness});
  };
  if (is_log) {
    for_each_place(nodes, [&](double x) { add(x, function->GetValue(x), kMiddle, 0); });
  } else {
    for (const Node& node : nodes) add(node[0], node[1], node[2], node[3]);
  }
  if (points.empty()) return {{0, 0}};  // VTK's answer, 0
  if (function->GetClamping() == 0) {   // nothing beyond the ends
    points.insert(points.begin(), {points.front().x, 0});
    points.push_back({points.back().x, 0});
  }
  return points;
}

}  // namespace ovoid::mappers
