// SPDX-License-Identifier: Apache-2.0
#include "picture_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <sstream>

#include "ovoid/space_part.h"

namespace ovoid::cli {
namespace {

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string words_of(const Vec3& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }

std::string name_of_line(const std::string& line) { return line.substr(0, line.find(' ')); }

}  // namespace

std::string picture_lines(const FrameSubject& subject, const Camera& camera,
                          const RenderOptions& options) {
  const Field& field = subject.field;
  const Bounds3 bounds = field.world_bounds();
  const ValueRange range = field.value_range();
  std::string lines =
      fmt::format("data {} kernels, values {} to {}, from {} to {}\n", field.num_kernels(),
                  range.lo, range.hi, words_of(bounds.min()), words_of(bounds.max()));
  if (subject.surface != nullptr)
    lines += fmt::format("surface {} triangles, walls {}\n", subject.surface->triangles.size(),
                         subject.walls.opacity);
  if (subject.points) lines += fmt::format("points {}\n", subject.points->size);
  lines += fmt::format("size {}x{}\n", options.width, options.height);
  lines += fmt::format("sampling-distance {}\n", sheet_distance(field, subject.look, options));
  lines += fmt::format("sampling {} {} {} {}\n", static_cast<int>(options.classification),
                       static_cast<int>(options.slab), static_cast<int>(options.gradient),
                       static_cast<int>(options.post_convolution));
  for (const ClipPlane& plane : options.clip_planes)
    lines += fmt::format("clip {} {}\n", words_of(plane.normal), plane.offset);
  lines += "camera " + in_one_line(to_text(camera)) + "\n";
  lines += "look " + in_one_line(to_text(subject.look)) + "\n";
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

PicturePart draw_part(Renderer& renderer, const FrameSubject& subject, const Camera& camera,
                      RenderOptions options, int number, int count, const RenderHooks& hooks) {
  const std::vector<SpacePart> parts = split_space(subject.field, count);
  options.part = std::make_shared<SpacePart>(parts[static_cast<std::size_t>(number) - 1]);
  PicturePart part;
  part.number = number;
  part.count = count;
  part.picture = picture_lines(subject, camera, options);
  part.look = subject.look;
  part.seen = *draw_frame(renderer, subject, camera, options, hooks).seen;
  return part;
}

Image picture_of(const DeepImage& seen, Look look, const LookFlags& flags, bool is_for_eyes,
                 Session& session) {
  Image image = composited(seen, look);
  if (seen.mode == Mode::kXray && is_for_eyes) {
    spread_over_integrals(look.transfer_function, image, flags, session);
    color_integrals(image, look.transfer_function);
  }
  return image;
}

}  // namespace ovoid::cli
