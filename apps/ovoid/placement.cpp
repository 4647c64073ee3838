// SPDX-License-Identifier: Apache-2.0
#include "placement.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::cli {
namespace {

constexpr std::size_t kMostBytes = 1 << 20;

// What is wrong with a file.
class BadPlacement {
 public:
  explicit BadPlacement(const std::string& source) : source_(source) {}
  [[noreturn]] void operator()(const std::string& why) const {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': {}", source_, why));
  }

 private:
  const std::string& source_;
};

double number_of(const std::string& word, const BadPlacement& refuse) {
  std::size_t used = 0;
  double number = 0;
  try {
    number = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || !std::isfinite(number))
    refuse(fmt::format("'{}' is no number", word.substr(0, 40)));
  return number;
}

std::vector<double> numbers_of(std::string text, const BadPlacement& refuse) {
  for (char& c : text) {
    if (c == ',' || c == ';' || c == '[' || c == ']') c = ' ';
  }
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; words >> word;) numbers.push_back(number_of(word, refuse));
  return numbers;
}

std::string without_comments(const std::string& text) {
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) out += line.substr(0, line.find('#')) + '\n';
  return out;
}

Affine3 matrix_of(const std::string& text, const BadPlacement& refuse) {
  const std::vector<double> numbers = numbers_of(without_comments(text), refuse);
  if (numbers.size() != 16 && numbers.size() != 12) {
    refuse(fmt::format("has {} numbers, expected the 16 of a 4x4 matrix, or an ITK transform",
                       numbers.size()));
  }
  const bool is_affine = numbers.size() == 12 || (numbers[12] == 0 && numbers[13] == 0 &&
                                                  numbers[14] == 0 && numbers[15] == 1);
  if (!is_affine) refuse("the last row of the matrix is not 0 0 0 1");
  Affine3 out = Affine3::Identity();
  for (int i = 0; i < 12; ++i) out.matrix()(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
  return out;
}

// One transform of a file: its kind, without the numbers' type and dimensions, and its numbers.
struct ItkTransform {
  std::string kind;
  std::vector<double> parameters, fixed;
};

constexpr std::string_view kItkMark = "#Insight Transform File";

std::vector<ItkTransform> itk_transforms(const std::string& text, const BadPlacement& refuse) {
  std::vector<ItkTransform> all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const auto value_of = [&](std::string_view name) -> std::optional<std::string> {
      if (line.rfind(name, 0) != 0) return std::nullopt;
      return line.substr(name.size());
    };
    if (const auto type = value_of("Transform:")) {
      const std::string name = type->substr(std::min(type->find_first_not_of(' '), type->size()));
      constexpr std::string_view kThree = "_3_3";
      const auto end = name.find('_');
      const std::size_t last = name.find_last_not_of(" \t");
      const std::string whole = last == std::string::npos ? name : name.substr(0, last + 1);
      if (end == std::string::npos || !std::string_view(whole).ends_with(kThree))
        refuse(fmt::format("'{}' is no transform of three dimensions", whole.substr(0, 60)));
      all.push_back({whole.substr(0, end), {}, {}});
    } else if (const auto parameters = value_of("Parameters:"); parameters && !all.empty()) {
      all.back().parameters = numbers_of(*parameters, refuse);
    } else if (const auto fixed = value_of("FixedParameters:"); fixed && !all.empty()) {
      all.back().fixed = numbers_of(*fixed, refuse);
    }
  }
  if (all.empty()) refuse("names no transform");
  return all;
}

Vec3 vector_at(const std::vector<double>& numbers, std::size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

// ITK's, about a centre: y = M (x - c) + c + t.
Affine3 about_center(const Mat3& matrix, const Vec3& translation, const ItkTransform& transform) {
  const Vec3 center =
      transform.fixed.size() >= 3 ? vector_at(transform.fixed, 0) : Vec3(Vec3::Zero());
  Affine3 out = Affine3::Identity();
  out.linear() = matrix;
  out.translation() = translation + center - matrix * center;
  return out;
}

Mat3 rotation_of_versor(const Vec3& versor, const BadPlacement& refuse) {
  const double rest = 1 - versor.squaredNorm();
  if (rest < -1e-9) refuse("its versor is longer than 1");
  return Eigen::Quaterniond(std::sqrt(std::max(rest, 0.0)), versor[0], versor[1], versor[2])
      .toRotationMatrix();
}

Affine3 affine_of(const ItkTransform& transform, const BadPlacement& refuse) {
  const std::vector<double>& p = transform.parameters;
  const auto require = [&](std::size_t count) {
    if (p.size() == count) return;
    refuse(fmt::format("{} has {} parameters, expected {}", transform.kind, p.size(), count));
  };
  const std::string& kind = transform.kind;
  if (kind == "IdentityTransform") return Affine3::Identity();
  if (kind == "TranslationTransform") {
    require(3);
    return Affine3(Eigen::Translation3d(vector_at(p, 0)));
  }
  if (kind == "AffineTransform" || kind == "MatrixOffsetTransformBase" ||
      kind == "Rigid3DTransform" || kind == "ScaleSkewVersor3DTransformBase") {
    require(12);
    Mat3 matrix;
    for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = p[static_cast<std::size_t>(i)];
    return about_center(matrix, vector_at(p, 9), transform);
  }
  if (kind == "Euler3DTransform") {
    require(6);
    const auto turn = [](double angle, const Vec3& axis) {
      return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    };
    const Mat3 x = turn(p[0], Vec3::UnitX());
    const Mat3 y = turn(p[1], Vec3::UnitY());
    const Mat3 z = turn(p[2], Vec3::UnitZ());
    const bool is_zyx = transform.fixed.size() >= 4 && transform.fixed[3] != 0;
    return about_center(is_zyx ? Mat3(z * y * x) : Mat3(z * x * y), vector_at(p, 3), transform);
  }
  if (kind == "VersorRigid3DTransform") {
    require(6);
    return about_center(rotation_of_versor(vector_at(p, 0), refuse), vector_at(p, 3), transform);
  }
  if (kind == "Similarity3DTransform") {
    require(7);
    return about_center(p[6] * rotation_of_versor(vector_at(p, 0), refuse), vector_at(p, 3),
                        transform);
  }
  refuse(fmt::format(
      "{} is none of the transforms that place a volume: translation, rigid, similarity or affine",
      kind));
}

// Of a composite transform the last one is applied first.
Affine3 itk_affine_of(const std::string& text, const BadPlacement& refuse) {
  const std::vector<ItkTransform> all = itk_transforms(text, refuse);
  const bool is_composite = all.front().kind == "CompositeTransform";
  if (!is_composite && all.size() > 1)
    refuse(fmt::format("has {} transforms, expected one, or a composite", all.size()));
  Affine3 out = Affine3::Identity();
  for (std::size_t i = is_composite ? 1 : 0; i < all.size(); ++i)
    out = out * affine_of(all[i], refuse);
  return out;
}

void require_invertible(const Affine3& map, const BadPlacement& refuse) {
  constexpr double kLeastVolume = 1e-9;  // of the box of the columns' lengths
  const Mat3 linear = map.linear();
  const double box = linear.col(0).norm() * linear.col(1).norm() * linear.col(2).norm();
  if (!map.matrix().allFinite() || !(std::abs(linear.determinant()) > kLeastVolume * box))
    refuse("the matrix is singular: it leaves nothing of a volume");
}

}  // namespace

Affine3 between_spaces(Space from, Space to) {
  if (from == to || from == Space::kNone || to == Space::kNone) return Affine3::Identity();
  return Affine3(Eigen::Scaling(-1.0, -1.0, 1.0));
}

Affine3 placement_from_text(const std::string& text, const std::string& source, Space space) {
  const BadPlacement refuse(source);
  if (text.find('\0') != std::string::npos)
    refuse("is no text; expected a 4x4 matrix or an ITK transform, as text");
  if (!std::string_view(text).starts_with(kItkMark)) {
    Affine3 matrix = matrix_of(text, refuse);
    require_invertible(matrix, refuse);
    return matrix;
  }
  const Affine3 moving_from_fixed = itk_affine_of(text, refuse);
  require_invertible(moving_from_fixed, refuse);
  const Affine3 world_from_lps = between_spaces(Space::kLps, space);
  return world_from_lps * moving_from_fixed.inverse() * world_from_lps.inverse();
}

Affine3 read_placement(const std::string& path, Space space) {
  return placement_from_text(read_text_file(path, kMostBytes), path, space);
}

}  // namespace ovoid::cli
