// SPDX-License-Identifier: Apache-2.0
// make_vdb FOLDER: writes the OpenVDB files that tests read, by OpenVDB's own library. A program of
// its own, since that library takes longer to load than most tests to run. What is in the files is
// said in src/io/vdb/vdb_test.cpp, where each is read.
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace {

using openvdb::Coord;
using openvdb::GridBase;
using openvdb::math::Transform;

std::string folder;

std::string path(const std::string& name) { return folder + "/" + name; }

void write(const std::string& name, const openvdb::GridPtrVec& grids,
           std::uint32_t compression = openvdb::io::Archive::DEFAULT_COMPRESSION_FLAGS,
           bool has_statistics = true) {
  openvdb::io::File file(path(name));
  file.setCompression(compression);
  file.setGridStatsMetadataEnabled(has_statistics);
  file.write(grids);
}

// Each voxel of the box, both ends in it, has the value that it is given by its place.
template <typename Grid, typename Value>
typename Grid::Ptr grid_of(const std::string& name, const typename Grid::ValueType& background,
                           const openvdb::CoordBBox& box, const Value& value) {
  const auto grid = Grid::create(background);
  grid->setName(name);
  auto voxels = grid->getAccessor();
  for (auto at = box.begin(); at; ++at) voxels.setValue(*at, value(*at));
  return grid;
}

float counted(const Coord& at) {
  return static_cast<float>(at.x()) + 0.5F * static_cast<float>(at.y()) +
         0.25F * static_cast<float>(at.z());
}

openvdb::FloatGrid::Ptr counted_grid(const std::string& name = "density") {
  return grid_of<openvdb::FloatGrid>(name, 0.0F, {Coord(-3, 2, 0), Coord(8, 9, 20)}, counted);
}

Transform::Ptr scaled(double voxel, const openvdb::Vec3d& place) {
  const auto transform = Transform::createLinearTransform(voxel);
  transform->postTranslate(place);
  return transform;
}

// All kinds of numbers, on one lattice, in boxes of their own.
openvdb::GridPtrVec kinds() {
  using namespace openvdb;
  const CoordBBox small(Coord(0, 3, 1), Coord(2, 5, 4));
  const auto sum = [](const Coord& at) { return at.x() + 10 * at.y() + 100 * at.z(); };
  const auto vector = [](const Coord& at) { return Vec3f(counted(at), 1.0F, -2.0F); };
  GridPtrVec grids{
      grid_of<DoubleGrid>("temperature", 300.0, small,
                          [&](const Coord& at) { return 0.1 * sum(at); }),
      counted_grid(),
      grid_of<Int32Grid>("number", -1, small, sum),
      grid_of<Int64Grid>("large", -1, small,
                         [&](const Coord& at) { return (Int64{1} << 40) + sum(at); }),
      grid_of<BoolGrid>("inside", false, small, [](const Coord& at) { return at.x() != 1; }),
      grid_of<MaskGrid>("mask", false, small, [](const Coord&) { return true; }),
      grid_of<Vec3SGrid>("v", Vec3f(0.0F), small, vector),
      grid_of<Vec3DGrid>("vd", Vec3d(0.0), small, vector),
      grid_of<Vec3IGrid>("vi", Vec3i(7), small,
                         [](const Coord& at) { return Vec3i(at.asPointer()); })};
  for (const auto& grid : grids) grid->setTransform(scaled(0.5, {1, 2, 3}));
  return grids;
}

void write_storage() {
  const auto half = counted_grid();
  half->setSaveFloatAsHalf(true);
  write("half.vdb", {half});
  write("plain.vdb", {counted_grid()}, openvdb::io::COMPRESS_NONE);
  write("zip.vdb", {counted_grid()}, openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  write("blosc.vdb", {counted_grid()},
        openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
  std::ofstream stream(path("stream.vdb"), std::ios::binary);
  openvdb::io::Stream(stream).write(openvdb::GridPtrVec{counted_grid()});
}

void write_places() {
  using namespace openvdb;
  const auto affine = counted_grid();
  const Mat4d matrix(Vec4d(0.5, 0.25, 0, 0), Vec4d(-0.5, 1, 0.125, 0), Vec4d(0, 0.5, 2, 0),
                     Vec4d(4, 5, 6, 1));
  affine->setTransform(Transform::createLinearTransform(matrix));
  write("affine.vdb", {affine});
  const auto frustum = counted_grid();
  frustum->setTransform(Transform::createFrustumTransform(BBoxd(Vec3d(0), Vec3d(10)), 0.5, 10, 1));
  write("frustum.vdb", {frustum});
  const auto coarse = counted_grid("coarse");
  coarse->setTransform(scaled(2, {0, 0, 0}));
  const auto moved = counted_grid("moved");  // by whole voxels: it has the same lattice
  moved->setTransform(scaled(1, {2, 0, -1}));
  const auto between = counted_grid("between");
  between->setTransform(scaled(1, {0.5, 0, 0}));
  write("places.vdb", {coarse, frustum->deepCopyGrid(), counted_grid(), moved, between});
  const auto far = FloatGrid::create();
  far->setName("far");
  far->tree().setValue(Coord(-1000000, 0, 0), 1.0F);
  far->tree().setValue(Coord(1000000, 1000000, 1000000), 1.0F);
  write("far.vdb", {far});
}

void write_odd() {
  using namespace openvdb;
  const auto empty = FloatGrid::create(2);
  empty->setName("empty");
  write("empty.vdb", {empty});
  write("nothing.vdb", {});
  const auto tiles = FloatGrid::create(1);
  tiles->setName("tiles");
  tiles->fill({Coord(0), Coord(39, 8, 7)}, 4.0F);  // of 8^3 voxels, and single ones
  tiles->fill({Coord(16, 0, 0), Coord(23, 7, 7)}, -2.0F,
              false);  // not active, and a value all the same
  tiles->pruneGrid();
  write("tiles.vdb", {tiles});
  const auto shared = counted_grid("shared");
  const auto instance = FloatGrid::create(shared->treePtr());
  instance->setName("instance");
  write("names.vdb", {counted_grid(), counted_grid(), counted_grid(""), shared, instance});
  const auto staggered = grid_of<Vec3SGrid>("v", Vec3f(0.0F), {Coord(0), Coord(3)},
                                            [](const Coord& at) { return Vec3f(counted(at)); });
  staggered->setGridClass(GRID_STAGGERED);
  write("staggered.vdb", {staggered});
  const auto sphere = tools::createLevelSetSphere<FloatGrid>(5.0F, Vec3f(1, 2, 3), 0.25F, 3.0F);
  sphere->setName("surface");
  write("sphere.vdb", {sphere});
}

// Three steps of a box that moves, the second without statistics in its metadata, the last with
// none.
void write_steps() {
  using namespace openvdb;
  for (int step = 0; step < 3; ++step) {
    const Coord first(4 * step, 0, -step);
    const auto grid = grid_of<FloatGrid>("density", 0.0F, {first, first.offsetBy(3)}, counted);
    grid->setTransform(scaled(0.5, {0, 0, 0}));
    write("step" + std::to_string(step) + ".vdb", {grid}, io::Archive::DEFAULT_COMPRESSION_FLAGS,
          step != 1);
  }
  const auto empty = FloatGrid::create();
  empty->setName("density");
  empty->setTransform(scaled(0.5, {0, 0, 0}));
  write("step3.vdb", {empty});
}

void write_points() {
  using namespace openvdb;
  std::vector<Vec3R> places;
  std::vector<float> sizes;
  std::vector<Vec3f> velocities;
  for (int i = 0; i < 40; ++i) {
    places.emplace_back(0.25 * i, 1.0 - 0.125 * i, 0.0625 * i * i);
    sizes.push_back(static_cast<float>(i));
    velocities.emplace_back(static_cast<float>(i), 0.0F, 1.0F);
  }
  const auto transform = scaled(0.5, {1, 2, 3});
  const points::PointAttributeVector<Vec3R> positions(places);
  const auto index = tools::createPointIndexGrid<tools::PointIndexGrid>(positions, *transform);
  const auto grid = points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(
      *index, positions, *transform);
  grid->setName("points");
  auto& tree = grid->tree();
  points::appendAttribute<float>(tree, "size");
  points::appendAttribute<Vec3f>(tree, "v");
  points::PointAttributeVector<float> size(sizes);
  points::PointAttributeVector<Vec3f> velocity(velocities);
  points::populateAttribute<points::PointDataTree, tools::PointIndexTree,
                            points::PointAttributeVector<float>>(tree, index->tree(), "size", size);
  points::populateAttribute<points::PointDataTree, tools::PointIndexTree,
                            points::PointAttributeVector<Vec3f>>(tree, index->tree(), "v",
                                                                 velocity);
  write("points.vdb", {grid});
  write("both.vdb", {grid, counted_grid()});
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fputs("usage: make_vdb FOLDER\n", stderr);
    return 2;
  }
  folder = arguments[1];
  openvdb::initialize();
  write("kinds.vdb", kinds());
  write_storage();
  write_places();
  write_odd();
  write_steps();
  write_points();
}
