// SPDX-License-Identifier: Apache-2.0
#include "picture_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <utility>

#include "console.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"
#include "ovoid/space_part.h"

namespace ovoid::cli {
namespace {

std::string words_of(const Vec3& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }

// FNV-1a over numbers, in the order in which they are added.
class Digest {
 public:
  template <class T>
  void add(const T& number) {
    for (const std::byte byte : std::as_bytes(std::span(&number, 1)))
      sum_ = (sum_ ^ std::to_integer<std::uint64_t>(byte)) * 1099511628211U;
  }
  void add(const ValueRange& range) {
    add(range.lo);
    add(range.hi);
  }
  void add(const Vec3& place) {
    for (const double coordinate : {place[0], place[1], place[2]}) add(coordinate);
  }
  std::uint64_t value() const noexcept { return sum_; }

 private:
  std::uint64_t sum_ = 14695981039346656037U;
};

// Of what every process knows of its bricks: other values, or other places, have others.
std::uint64_t digest_of(const Field& field) {
  Digest digest;
  if (const LatticeField* const lattice = field.lattice()) {
    const BrickSource& source = lattice->source();
    const LatticeGeometry& geometry = source.geometry();
    for (const std::int64_t size : geometry.dims) digest.add(size);
    const std::int64_t edge = source.brick_edge();
    const auto num_bricks = [&](std::size_t axis) { return (geometry.dims[axis] - 1) / edge + 1; };
    for (std::int64_t z = 0; z < num_bricks(2); ++z) {
      for (std::int64_t y = 0; y < num_bricks(1); ++y) {
        for (std::int64_t x = 0; x < num_bricks(0); ++x) digest.add(source.brick_range(x, y, z));
      }
    }
  } else if (const KernelField* const set = field.kernels()) {
    const KernelSource& source = set->source();
    for (std::int64_t i = 0; i < source.num_bricks(); ++i) {
      const KernelBrick& brick = source.brick(i);
      digest.add(brick.count);
      digest.add(Vec3(brick.support.min()));
      digest.add(Vec3(brick.support.max()));
      for (std::size_t a = 0; a < source.attributes().size(); ++a) digest.add(brick.ranges[a]);
    }
  }
  return digest.value();
}

// Of a file by its length and pieces of it, evenly spread.
std::uint64_t digest_of_file(const std::string& path) {
  constexpr std::int64_t kPieces = 64, kPieceBytes = 4096;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::int64_t>(file.tellg());
  if (!file)
    throw Error(ErrorCode::kFileNotFound,
                fmt::format("'{}': cannot be read: {}", path, std::strerror(errno)));
  Digest digest;
  digest.add(size);
  std::array<char, kPieceBytes> piece{};
  for (std::int64_t i = 0; i < kPieces; ++i) {
    file.seekg(std::max<std::int64_t>(0, size - kPieceBytes) / (kPieces - 1) * i);
    file.read(piece.data(), std::min(kPieceBytes, size));
    digest.add(piece);
  }
  return digest.value();
}

std::uint64_t digest_of(const Surface& surface) {
  Digest digest;
  for (const Vec3& place : surface.places) digest.add(place);
  return digest.value();
}

std::string field_line(const char* name, const Field& field) {
  const Bounds3 bounds = field.world_bounds();
  const ValueRange range = field.value_range();
  return fmt::format("{} {} kernels, values {} to {}, from {} to {}, {:016x}\n", name,
                     field.num_kernels(), range.lo, range.hi, words_of(bounds.min()),
                     words_of(bounds.max()), digest_of(field));
}

std::string words_of(const TransferFunction& colors) {
  Look look;
  look.transfer_function = colors;
  return one_line(to_text(look));
}

std::string words_of(const Rgb& color) {
  return fmt::format("{} {} {}", color[0], color[1], color[2]);
}

// Of labels by what holds at some places all over the map.
std::uint64_t digest_of(const LabelMap& map) {
  constexpr std::int64_t kAlong = 6;
  Digest digest;
  const LatticeGeometry& geometry = map.geometry();
  for (const int label : map.labels()) digest.add(label);
  for (const std::int64_t size : geometry.dims) digest.add(size);
  const Vec3 size(static_cast<double>(geometry.dims[0]), static_cast<double>(geometry.dims[1]),
                  static_cast<double>(geometry.dims[2]));
  for (std::int64_t i = 0; i < kAlong * kAlong * kAlong; ++i) {
    const Index3 cell{i % kAlong, i / kAlong % kAlong, i / (kAlong * kAlong)};
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis) {
      const auto along = static_cast<double>(cell[static_cast<std::size_t>(axis)]) + 0.45;
      index[axis] = along / static_cast<double>(kAlong) * size[axis] - 0.5;
    }
    const Vec3 place = geometry.world_from_index * index;
    digest.add(place);
    digest.add(map.label_at(place).value_or(-1));
  }
  return digest.value();
}

// What is seen beside the field.
std::string scenery_lines(const Scene& scene) {
  std::string lines;
  for (const Geometry& one : scene.surfaces) {
    lines +=
        fmt::format("add {} triangles, {:016x}, color {}, opacity {}, edges {}, colors {}\n",
                    one.surface->triangles.size(), digest_of(*one.surface), words_of(one.color),
                    one.opacity, one.shows_edges, one.colors ? words_of(*one.colors) : "none");
  }
  for (const FieldSlice& slice : scene.slices) {
    lines += fmt::format("slice {} {}, opacity {}, outline {}, colors {}\n", words_of(slice.normal),
                         slice.offset, slice.opacity,
                         slice.outline ? words_of(*slice.outline) : "none", words_of(slice.colors));
  }
  const LabelSurfaces& labels = scene.labels;
  if (labels.map == nullptr) return lines;
  lines += fmt::format("labels {:016x}, {} {} {} {}", digest_of(*labels.map),
                       labels.shows_field_elsewhere, labels.shows_surfaces, labels.slice_lines,
                       labels.slice_areas);
  for (const LabelStyle& style : labels.styles) {
    lines += fmt::format(", {} {} {} {}", style.label, words_of(style.color), style.opacity,
                         style.shows_field);
  }
  return lines + "\n";
}

std::string name_of_line(const std::string& line) { return line.substr(0, line.find(' ')); }

}  // namespace

std::string data_lines(const std::vector<std::string>& inputs) {
  std::string lines;
  for (const std::string& input : inputs) {
    if (!std::filesystem::is_directory(input))
      lines += fmt::format("data {:016x}\n", digest_of_file(input));
  }
  return lines;
}

std::string picture_lines(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  const auto& [field, look, trail, boundary, walls, points] = scene.volumes.front();
  std::string lines = field_line("data", field);
  if (scene.volumes.size() > 1) {
    for (std::size_t i = 1; i < scene.volumes.size(); ++i)
      lines += field_line("over", scene.volumes[i].field) + "over-look " +
               one_line(to_text(scene.volumes[i].look)) + "\n";
    lines += fmt::format("mixing {}\n", static_cast<int>(scene.mixing));
  }
  lines += scenery_lines(scene);
  if (boundary != nullptr)
    lines += fmt::format("surface {} triangles, {:016x}, walls {} {}\n", boundary->triangles.size(),
                         digest_of(*boundary), walls.opacity, walls.shows_edges);
  if (points) lines += fmt::format("points {}\n", points->size);
  lines += fmt::format("size {}x{}\n", options.width, options.height);
  lines += fmt::format("sampling-distance {}\n", sheet_distance(field, look, options));
  lines += fmt::format("sampling {} {} {} {} {} {}\n", static_cast<int>(options.classification),
                       static_cast<int>(options.slab), static_cast<int>(options.gradient),
                       static_cast<int>(options.post_convolution), static_cast<int>(options.spread),
                       options.opaque_at);
  for (const ClipPlane& plane : options.clip_planes)
    lines += fmt::format("clip {} {}\n", words_of(plane.normal), plane.offset);
  lines += "camera " + one_line(to_text(camera)) + "\n";
  lines += "look " + one_line(to_text(look)) + "\n";
  return lines;
}

std::string differing_line(const std::string& a, const std::string& b) {
  std::istringstream of_a(a);
  std::istringstream of_b(b);
  std::string in_a;
  std::string in_b;
  while (true) {
    const bool has_a = static_cast<bool>(std::getline(of_a, in_a));
    const bool has_b = static_cast<bool>(std::getline(of_b, in_b));
    if (!has_a && !has_b) return "";
    if (has_a && has_b && in_a == in_b) continue;
    return name_of_line(has_a ? in_a : in_b);
  }
}

PicturePart draw_part(Renderer& renderer, const Scene& scene, const Camera& camera,
                      RenderOptions options, const PartChoice& choice, const RenderHooks& hooks,
                      Session& session) {
  const auto [number, count] = choice;
  const std::vector<SpacePart> parts = split_space(scene.volumes.front().field, count);
  options.part = std::make_shared<SpacePart>(parts[static_cast<std::size_t>(number) - 1]);
  PicturePart part;
  part.number = number;
  part.count = count;
  part.picture = picture_lines(scene, camera, options);
  part.look = scene.volumes.front().look;
  Frame frame = renderer.render(scene, camera, options, hooks);
  if (!frame.profile.notice.empty()) session.note(frame.profile.notice);
  part.seen = std::move(frame.seen.value());
  return part;
}

Image picture_of(const DeepImage& seen, Look look, const LookFlags& flags, bool is_for_eyes,
                 Session& session) {
  Image image = composited(seen, look);
  if (is_empty(image)) session.note("nothing shows in any part");
  if (seen.mode == Mode::kXray && is_for_eyes) {
    spread_over_integrals(look.transfer_function, image, flags, session);
    color_integrals(image, look.transfer_function);
  }
  return image;
}

}  // namespace ovoid::cli
