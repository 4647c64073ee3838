// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/gltf.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "io/core/signatures.h"
#include "io/meshes/gltf_file.h"
#include "io/meshes/surface_builder.h"
#include "ovoid/error.h"
#include "ovoid/math.h"

namespace ovoid::io {
namespace {

// How a primitive's nodes become cells, as glTF numbers it.
enum class Primitive { kPoints, kLines, kLoop, kStrip, kTriangles, kTriangleStrip, kFan };

constexpr std::int64_t kMostCorners = std::int64_t{1} << 28;

std::vector<double> numbers_in(const JsonValue& list, std::size_t count) {
  list.array_of(count);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(list.element(i).number());
  return numbers;
}

// From a node's own frame into that of the node that it is in.
Affine3 placed_by(const JsonValue& node) {
  Affine3 placed = Affine3::Identity();
  if (node.has("matrix")) {
    const std::vector<double> columns = numbers_in(node.member("matrix"), 16);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i % 4);
      if (row < 3) placed(row, static_cast<Eigen::Index>(i / 4)) = columns[i];
    }
    return placed;
  }
  if (node.has("translation")) {
    const std::vector<double> by = numbers_in(node.member("translation"), 3);
    placed.translate(Vec3(by[0], by[1], by[2]));
  }
  if (node.has("rotation")) {
    const std::vector<double> q = numbers_in(node.member("rotation"), 4);
    const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
    if (!(turn.norm() > 0)) node.member("rotation").refuse("must not be 0");
    placed.rotate(turn.normalized());
  }
  if (node.has("scale")) {
    const std::vector<double> by = numbers_in(node.member("scale"), 3);
    placed.scale(Vec3(by[0], by[1], by[2]));
  }
  return placed;
}

class SceneReader {
 public:
  SceneReader(const GltfFile& file, SurfaceBuilder& surface) : file_(file), surface_(surface) {}

  // Every node of the scene, where those that it is in put it.
  void read() {
    std::vector<std::pair<std::size_t, Affine3>> open;
    for (const std::size_t root : roots()) open.emplace_back(root, Affine3::Identity());
    std::vector<bool> is_known(file_.count("nodes"));
    while (!open.empty()) {
      const auto [number, frame] = open.back();
      open.pop_back();
      const JsonValue node = file_.element("nodes", number);
      if (is_known[number]) node.refuse("is in the scene more than once");
      is_known[number] = true;
      const Affine3 world = frame * placed_by(node);
      if (node.has("mesh"))
        add_mesh(file_.element("meshes", file_.index(node.member("mesh"), "meshes")), world);
      if (!node.has("children")) continue;
      const JsonValue children = node.member("children").array();
      for (std::size_t c = 0; c < children.size(); ++c)
        open.emplace_back(file_.index(children.element(c), "nodes"), world);
    }
  }

 private:
  // Of the scene that the file names, or the first; without scenes all nodes that are in no other.
  std::vector<std::size_t> roots() const {
    std::vector<std::size_t> all;
    if (file_.count("scenes") > 0) {
      const std::size_t number =
          file_.text().has("scene") ? file_.index(file_.text().member("scene"), "scenes") : 0;
      const JsonValue scene = file_.element("scenes", number);
      if (!scene.has("nodes")) return all;
      const JsonValue nodes = scene.member("nodes").array();
      for (std::size_t i = 0; i < nodes.size(); ++i)
        all.push_back(file_.index(nodes.element(i), "nodes"));
      return all;
    }
    std::vector<bool> is_child(file_.count("nodes"));
    for (std::size_t n = 0; n < is_child.size(); ++n) {
      const JsonValue node = file_.element("nodes", n);
      if (!node.has("children")) continue;
      const JsonValue children = node.member("children").array();
      for (std::size_t c = 0; c < children.size(); ++c)
        is_child[file_.index(children.element(c), "nodes")] = true;
    }
    for (std::size_t n = 0; n < is_child.size(); ++n)
      if (!is_child[n]) all.push_back(n);
    return all;
  }

  void add_mesh(const JsonValue& mesh, const Affine3& world) {
    const JsonValue primitives = mesh.member("primitives").array();
    for (std::size_t i = 0; i < primitives.size(); ++i)
      add_primitive(primitives.element(i).object(), world);
  }

  void add_primitive(const JsonValue& primitive, const Affine3& world) {
    const JsonValue attributes = primitive.member("attributes").object();
    // What is compressed has accessors without numbers.
    if (primitive.has("extensions") &&
        primitive.member("extensions").has("KHR_draco_mesh_compression"))
      throw Error(ErrorCode::kUnsupported,
                  primitive.place() + ": geometry compressed by Draco is not read");
    if (!attributes.has("POSITION")) return;
    const GltfNumbers places = file_.numbers(attributes.member("POSITION"));
    if (places.components() != 3) attributes.member("POSITION").refuse("must be of VEC3");
    const std::int64_t first = surface_.num_nodes();
    if (first + places.count() > kMostCorners)
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: more than {} corners", primitive.place(), kMostCorners));
    for (std::int64_t i = 0; i < places.count(); ++i) {
      const Vec3 at = world * Vec3(places.at(i, 0), places.at(i, 1), places.at(i, 2));
      surface_.add_node({at.x(), at.y(), at.z()});
    }
    std::vector<std::uint32_t> nodes;
    if (primitive.has("indices")) {
      const GltfNumbers indices = file_.numbers(primitive.member("indices"));
      if (!indices.are_indices())
        primitive.member("indices").refuse("must be of unsigned whole numbers");
      nodes.reserve(static_cast<std::size_t>(indices.count()));
      for (std::int64_t i = 0; i < indices.count(); ++i) {
        const std::uint32_t node = indices.index_at(i);
        if (node >= places.count())
          primitive.member("indices").refuse(
              fmt::format("[{}] is {}, there are {} places", i, node, places.count()));
        nodes.push_back(static_cast<std::uint32_t>(first) + node);
      }
    } else {
      for (std::int64_t i = 0; i < places.count(); ++i)
        nodes.push_back(static_cast<std::uint32_t>(first + i));
    }
    const double mode = primitive.has("mode") ? primitive.member("mode").number() : 4;
    if (!(mode >= 0 && mode <= 6) || mode != std::trunc(mode))
      primitive.member("mode").refuse("expected 0 to 6");
    add_cells(static_cast<Primitive>(static_cast<int>(mode)), std::move(nodes));
  }

  void add_cells(Primitive primitive, std::vector<std::uint32_t> nodes) {
    const std::size_t count = nodes.size();
    const auto face = [&](std::size_t a, std::size_t b, std::size_t c) {
      surface_.add_face({nodes[a], nodes[b], nodes[c]});
    };
    switch (primitive) {
      case Primitive::kPoints:
        for (const std::uint32_t node : nodes) surface_.add_point(node);
        break;
      case Primitive::kLines:
        for (std::size_t i = 0; i + 1 < count; i += 2) surface_.add_line({nodes[i], nodes[i + 1]});
        break;
      case Primitive::kLoop:
        if (count > 1) nodes.push_back(nodes.front());
        [[fallthrough]];
      case Primitive::kStrip:
        if (count > 1) surface_.add_line(nodes);
        break;
      case Primitive::kTriangles:
        for (std::size_t i = 0; i + 2 < count; i += 3) face(i, i + 1, i + 2);
        break;
      case Primitive::kTriangleStrip:
        for (std::size_t i = 0; i + 2 < count; ++i)
          i % 2 == 0 ? face(i, i + 1, i + 2) : face(i + 1, i, i + 2);
        break;
      case Primitive::kFan:
        surface_.add_face(nodes);
        break;
    }
  }

  const GltfFile& file_;
  SurfaceBuilder& surface_;
};

}  // namespace

bool is_gltf(const ByteSource& source, std::string_view start) {
  return start.starts_with("glTF") || ending_of(source.name()) == ".gltf";
}

Dataset read_gltf(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  const GltfFile file(source, options, open);
  SurfaceBuilder surface;
  SceneReader(file, surface).read();
  return std::move(surface).finish(source, "glTF", options);
}

}  // namespace ovoid::io
