// SPDX-License-Identifier: Apache-2.0
// VTKHDF files, made as the format's page says. What would make it fail: numbers of another part or
// step, a step that is passed over, cells of a coarser level where there are finer ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

#ifdef OVOID_IO_HDF5
#include <hdf5.h>

#include <functional>
#include <memory>
#include <optional>
#include <random>

#include "fuzz/targets.h"
#include "io/foreign/hdf5_handle.h"
#include "io/reader/reader_session.h"
#include "support/where.h"

namespace ovoid::io {
namespace vtkhdf_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using Ints = std::vector<std::int64_t>;
using Reals = std::vector<double>;

// Makes a file; groups and datasets are named from its group VTKHDF on.
class VtkHdfMaker {
 public:
  VtkHdfMaker(const std::string& path, const std::string& type, const Ints& version = {2, 0})
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {
    block("", type);
    attribute("", "Version", version);
  }

  // A group with a type of its own.
  VtkHdfMaker& block(const std::string& name, const std::string& type) {
    group(name);
    const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(text.get(), type.size());
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle made(H5Acreate_by_name(file_.get(), place(name).c_str(), "Type", text.get(),
                                            space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    H5Awrite(made.get(), text.get(), type.data());
    return *this;
  }
  VtkHdfMaker& group(const std::string& name) {
    H5Gclose(H5Gcreate2(file_.get(), place(name).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    return *this;
  }
  VtkHdfMaker& attribute(const std::string& object, const char* name, const Ints& values) {
    return attribute_as(object, name, H5T_NATIVE_INT64, values);
  }
  VtkHdfMaker& attribute(const std::string& object, const char* name, const Reals& values) {
    return attribute_as(object, name, H5T_NATIVE_DOUBLE, values);
  }
  VtkHdfMaker& ints(const std::string& name, const Ints& values, std::vector<hsize_t> dims = {}) {
    return dataset(name, H5T_NATIVE_INT64, H5T_STD_I32BE, values, std::move(dims));
  }
  VtkHdfMaker& bytes(const std::string& name, const Ints& values, std::vector<hsize_t> dims) {
    return dataset(name, H5T_NATIVE_INT64, H5T_STD_U8LE, values, std::move(dims));
  }
  VtkHdfMaker& reals(const std::string& name, const Reals& values, std::vector<hsize_t> dims = {}) {
    return dataset(name, H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, values, std::move(dims));
  }
  VtkHdfMaker& link(const std::string& name, const std::string& target) {
    H5Lcreate_soft(target.c_str(), file_.get(), place(name).c_str(), H5P_DEFAULT, H5P_DEFAULT);
    return *this;
  }
  VtkHdfMaker& outside(const std::string& name) {
    H5Lcreate_external("other.h5", "/VTKHDF", file_.get(), place(name).c_str(), H5P_DEFAULT,
                       H5P_DEFAULT);
    return *this;
  }

  // A tetrahedron at each of `places`, whose points lie 1 apart, all of them in a part of its own.
  VtkHdfMaker& tetrahedra(const std::string& in, const Reals& places) {
    const auto count = static_cast<std::int64_t>(places.size());
    Reals points;
    Ints nodes, offsets;
    for (const double x : places) {
      points.insert(points.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0, x, 0, 1});
      nodes.insert(nodes.end(), {0, 1, 2, 3});
      offsets.insert(offsets.end(), {0, 4});
    }
    return ints(in + "NumberOfPoints", Ints(places.size(), 4))
        .ints(in + "NumberOfCells", Ints(places.size(), 1))
        .ints(in + "NumberOfConnectivityIds", Ints(places.size(), 4))
        .reals(in + "Points", points, {static_cast<hsize_t>(4 * count), 3})
        .ints(in + "Connectivity", nodes)
        .ints(in + "Offsets", offsets)
        .ints(in + "Types", Ints(places.size(), 10))
        .group(in + "PointData")
        .group(in + "CellData");
  }
  // Where each step begins.
  VtkHdfMaker& steps(const std::string& in, const Reals& times, const Ints& parts,
                     const Ints& num_parts, const Ints& points, const Ints& cells,
                     const Ints& ids) {
    const hsize_t count = times.size(), columns = cells.size() / times.size();
    return group(in + "Steps")
        .attribute(in + "Steps", "NSteps", Ints{static_cast<std::int64_t>(count)})
        .reals(in + "Steps/Values", times)
        .ints(in + "Steps/PartOffsets", parts)
        .ints(in + "Steps/NumberOfParts", num_parts)
        .ints(in + "Steps/PointOffsets", points)
        .ints(in + "Steps/CellOffsets", cells, {count, columns})
        .ints(in + "Steps/ConnectivityIdOffsets", ids, {count, columns})
        .group(in + "Steps/PointDataOffsets")
        .group(in + "Steps/CellDataOffsets");
  }
  VtkHdfMaker& image(const std::string& in, const Ints& extent) {
    return attribute(in, "WholeExtent", extent)
        .attribute(in, "Origin", Reals{10, 20, 30})
        .attribute(in, "Spacing", Reals{1, 2, 3})
        .attribute(in, "Direction", Reals{1, 0, 0, 0, 1, 0, 0, 0, 1})
        .group(in.empty() ? "PointData" : in + "/PointData")
        .group(in.empty() ? "CellData" : in + "/CellData");
  }

  // The file is whole only now.
  void close() { file_ = {}; }

 private:
  static std::string place(const std::string& name) {
    return name.empty() ? "/VTKHDF" : "/VTKHDF/" + name;
  }
  template <class T>
  VtkHdfMaker& attribute_as(const std::string& object, const char* name, hid_t type,
                            const std::vector<T>& values) {
    const hsize_t size = values.size();
    const Hdf5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
    const Hdf5Handle made(H5Acreate_by_name(file_.get(), place(object).c_str(), name, type,
                                            space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    H5Awrite(made.get(), type, values.data());
    return *this;
  }
  template <class T>
  VtkHdfMaker& dataset(const std::string& name, hid_t memory, hid_t stored,
                       const std::vector<T>& values, std::vector<hsize_t> dims) {
    if (dims.empty()) dims.push_back(values.size());
    // As VTK writes: in chunks, of an array that may grow.
    std::vector<hsize_t> most = dims, chunk = dims;
    most[0] = H5S_UNLIMITED;
    chunk[0] = 7;
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(plist.get(), static_cast<int>(chunk.size()), chunk.data());
    const Hdf5Handle space(
        H5Screate_simple(static_cast<int>(dims.size()), dims.data(), most.data()), H5Sclose);
    const Hdf5Handle made(H5Dcreate2(file_.get(), place(name).c_str(), stored, space.get(),
                                     H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                          H5Dclose);
    H5Dwrite(made.get(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    return *this;
  }

  Hdf5Handle file_;
};

class VtkHdf : public testing::Test {
 protected:
  Dataset read(std::optional<std::int64_t> step = {}, const std::string& block = {}) const {
    ReadOptions options;
    options.step = step;
    options.block = block;
    return read_dataset({path}, options);
  }
  std::string error() const {
    return error_of([&] { read_dataset({path}); });
  }

  TestFolder folder;
  std::string path = folder.file("a.vtkhdf");
};

TEST_F(VtkHdf, PartsOfOneStep) {
  VtkHdfMaker(path, "UnstructuredGrid", {1, 0})
      .tetrahedra("", {0, 5})
      .reals("PointData/f", {1, 2, 3, 4, 5, 6, 7, 8})
      .reals("PointData/v", counting<double>(24), {8, 3})
      .ints("CellData/c", {10, 20});
  const Dataset mesh = read();
  EXPECT_EQ(mesh.format, "VTKHDF");
  EXPECT_EQ(mesh.num_positions(), 8);
  EXPECT_EQ(mesh.cells.types, (std::vector(2, CellType::kTetrahedron)));
  EXPECT_EQ(mesh.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(values_of<double>(mesh.positions)[12], 5);
  EXPECT_EQ(values_of<double>(mesh.array("f")), counting<double>(8));
  EXPECT_EQ(mesh.array("v").num_components, 3);
  EXPECT_EQ(values_of<std::int32_t>(mesh.array("c")), (std::vector<std::int32_t>{10, 20}));
  EXPECT_EQ(mesh.num_steps, 1);
  ReadOptions options;
  options.array = "c";
  EXPECT_EQ(read_dataset({path}, options).arrays.size(), 1U);
}

// Early writers leave the type out.
TEST_F(VtkHdf, ATypeMayBeMissing) {
  const auto forget = [&] {
    const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    H5Adelete_by_name(file.get(), "/VTKHDF", "Type", H5P_DEFAULT);
  };
  VtkHdfMaker(path, "?", {1, 0}).tetrahedra("", {0}).reals("PointData/f", {1, 2, 3, 4});
  forget();
  EXPECT_EQ(read().cells.types, (std::vector{CellType::kTetrahedron}));
  VtkHdfMaker(path, "?", {1, 0})
      .image("", {0, 1, 0, 1, 0, 0})
      .reals("PointData/f", {1, 2, 3, 4}, {2, 2});
  forget();
  EXPECT_EQ(read().lattice.dims, (Index3{2, 2, 1}));
}

TEST_F(VtkHdf, StepsShareTheMesh) {
  VtkHdfMaker(path, "UnstructuredGrid")
      .tetrahedra("", {0})
      .reals("PointData/f", counting<double>(12))
      .reals("PointData/g", {1, 2, 3, 4})
      .reals("CellData/c", {7, 8, 9})
      .steps("", {0, 0.5, 1}, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0})
      .ints("Steps/PointDataOffsets/f", {0, 4, 8})
      .ints("Steps/CellDataOffsets/c", {0, 1, 2});
  const Dataset mesh = read(1);
  EXPECT_EQ(mesh.num_steps, 3);
  EXPECT_EQ(mesh.step, 1);
  EXPECT_THAT(mesh.times, ElementsAre(0, 0.5, 1));
  EXPECT_EQ(values_of<double>(mesh.array("f")), (Reals{5, 6, 7, 8}));
  EXPECT_EQ(values_of<double>(mesh.array("g")), (Reals{1, 2, 3, 4}));
  EXPECT_EQ(values_of<double>(mesh.array("c")), (Reals{8}));
  const auto steps = open_steps({path});
  EXPECT_THAT(steps->times(), ElementsAre(0, 0.5, 1));
  EXPECT_EQ(values_of<double>(steps->read(2).array("c")), (Reals{9}));
  EXPECT_THAT(error_of([&] { read(3); }), HasSubstr("step 3"));
}

TEST_F(VtkHdf, MeshesMove) {
  // The second step has two parts, the third those of the first.
  VtkHdfMaker(path, "UnstructuredGrid")
      .tetrahedra("", {0, 5, 9})
      .reals("PointData/f", counting<double>(12))
      .steps("", {0, 1, 2}, {0, 1, 0}, {1, 2, 1}, {0, 4, 0}, {0, 1, 0}, {0, 4, 0});
  const Dataset second = read(1);
  EXPECT_EQ(second.num_positions(), 8);
  EXPECT_EQ(values_of<double>(second.positions)[0], 5);
  EXPECT_EQ(values_of<double>(second.array("f")), (Reals{5, 6, 7, 8, 9, 10, 11, 12}));
  const Dataset third = read(2);
  EXPECT_EQ(third.num_positions(), 4);
  EXPECT_EQ(values_of<double>(third.array("f")), (Reals{1, 2, 3, 4}));
}

// Cells once, points of each step, and counts of each step's part.
TEST_F(VtkHdf, PointsMoveAndCellsStay) {
  VtkHdfMaker(path, "UnstructuredGrid")
      .tetrahedra("", {0, 5})
      .reals("PointData/f", counting<double>(8))
      .steps("", {0, 1}, {0, 1}, {1, 1}, {0, 4}, {0, 0}, {0, 0});
  const Dataset second = read(1);
  EXPECT_EQ(values_of<double>(second.positions)[0], 5);
  EXPECT_EQ(second.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(values_of<double>(second.array("f")), (Reals{5, 6, 7, 8}));
}

TEST_F(VtkHdf, PolygonsAndPoints) {
  const auto make = [&](const Ints& num_polygons, const Ints& polygons, const Ints& offsets) {
    VtkHdfMaker maker(path, "PolyData");
    maker.ints("NumberOfPoints", {4, 4})
        .reals("Points", counting<double>(24), {8, 3})
        .group("PointData")
        .reals("PointData/f", counting<double>(8))
        .group("CellData");
    for (const char* const kind : {"Vertices", "Lines", "Polygons", "Strips"}) {
      const bool is_vertices = kind == std::string("Vertices");
      const bool is_used = is_vertices || kind == std::string("Polygons");
      const std::string in = std::string(kind) + "/";
      maker.group(kind)
          .ints(in + "NumberOfCells", is_vertices ? Ints{4, 4}
                                      : is_used   ? num_polygons
                                                  : Ints{0, 0})
          .ints(in + "NumberOfConnectivityIds", is_vertices ? Ints{4, 4}
                                                : is_used   ? Ints{offsets[1], offsets[1]}
                                                            : Ints{0, 0})
          .ints(in + "Offsets", is_vertices ? Ints{0, 1, 2, 3, 4, 0, 1, 2, 3, 4}
                                : is_used   ? offsets
                                            : Ints{0, 0})
          .ints(in + "Connectivity", is_vertices ? Ints{0, 1, 2, 3, 0, 1, 2, 3}
                                     : is_used   ? polygons
                                                 : Ints{});
    }
    maker.steps("", {0, 1}, {0, 1}, {1, 1}, {0, 4}, {0, 0, 0, 0, 4, 0, num_polygons[0], 0},
                {0, 0, 0, 0, 4, 0, offsets[1], 0});
  };
  make({0, 0}, {}, {0, 0});
  const Dataset points = read(1);
  EXPECT_EQ(points.kind, DatasetKind::kParticles);
  EXPECT_EQ(values_of<double>(points.positions)[0], 13);
  EXPECT_EQ(values_of<double>(points.array("f")), (Reals{5, 6, 7, 8}));
  make({1, 1}, {0, 1, 2, 1, 2, 3}, {0, 3, 0, 3});
  ReadOptions faces;
  faces.faces = true;
  faces.step = 1;
  const Dataset surface = read_dataset({path}, faces);
  EXPECT_EQ(surface.kind, DatasetKind::kMesh);
  EXPECT_EQ(surface.cells.types.size(), 5U);
  EXPECT_EQ(surface.cells.types[4], CellType::kTriangle);
  EXPECT_EQ(surface.cells.connectivity[4], 1U);
  EXPECT_THAT(read(1).notes, Contains(HasSubstr("enclose no volume")));
}

TEST_F(VtkHdf, ImagesHaveTime) {
  VtkHdfMaker(path, "ImageData")
      .image("", {1, 3, 0, 1, 0, 1})
      .reals("PointData/f", counting<double>(24), {2, 2, 2, 3})
      .reals("PointData/v", counting<double>(72), {2, 2, 2, 3, 3})
      .reals("PointData/still", counting<double>(12), {1, 2, 2, 3})
      .reals("CellData/c", counting<double>(4), {2, 1, 1, 2})
      .group("Steps")
      .attribute("Steps", "NSteps", Ints{3})
      .reals("Steps/Values", {1, 2, 3})
      .group("Steps/PointDataOffsets")
      .ints("Steps/PointDataOffsets/f", {1, 0, 1})
      .ints("Steps/PointDataOffsets/v", {0, 1, 1})
      .ints("Steps/PointDataOffsets/still", {0, 0, 0})
      .group("Steps/CellDataOffsets")
      .ints("Steps/CellDataOffsets/c", {0, 1, 0});
  const Dataset dataset = read(1);
  EXPECT_EQ(dataset.kind, DatasetKind::kLattice);
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 2}));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(11, 20, 30));
  EXPECT_EQ(dataset.num_steps, 3);
  EXPECT_THAT(dataset.times, ElementsAre(1, 2, 3));
  EXPECT_EQ(values_of<double>(dataset.array("f")), counting<double>(12));
  EXPECT_EQ(dataset.array("v").num_components, 3);
  EXPECT_EQ(values_of<double>(dataset.array("v"))[0], 37);
  EXPECT_EQ(values_of<double>(dataset.array("c")), (Reals{3, 4}));
  EXPECT_EQ(values_of<double>(read(2).array("f"))[0], 13);
}

TEST_F(VtkHdf, PlaneImagesAndTurnedOnes) {
  VtkHdfMaker maker(path, "ImageData", {1, 0});
  maker.group("PointData")
      .reals("PointData/f", counting<double>(6), {2, 3})
      .attribute("", "WholeExtent", Ints{0, 2, 0, 1, 0, 0})
      .attribute("", "Origin", Reals{0, 0, 0})
      .attribute("", "Spacing", Reals{1, 2, 3})
      .attribute("", "Direction", Reals{0, 1, 0, -1, 0, 0, 0, 0, 1})
      .close();
  const Dataset dataset = read();
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 1}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().col(0), Vec3(0, -1, 0));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().col(1), Vec3(2, 0, 0));
}

TEST_F(VtkHdf, WhatGhostsOfAnImageHideIsMissing) {
  VtkHdfMaker(path, "ImageData")
      .image("", {0, 2, 0, 1, 0, 0})
      .reals("PointData/f", counting<double>(6), {1, 2, 3})
      .bytes("PointData/vtkGhostType", {2, 0, 0, 1, 0, 0}, {1, 2, 3})
      .close();
  const Dataset dataset = read();
  ASSERT_EQ(dataset.arrays.size(), 1U);
  const Reals values = values_of<double>(dataset.array("f"));
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(Reals(values.begin() + 1, values.end()), (Reals{2, 3, 4, 5, 6}));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("1 samples and 1 cells are hidden")));
}

// 2 x 1 x 1 cells, of which a finer level covers the second by 2 x 2 x 2 in two boxes.
void add_levels(VtkHdfMaker& maker, const char* data, const Reals& coarse, const Reals& fine,
                const Ints& fine_boxes) {
  maker.attribute("", "Origin", Reals{1, 0, 0});
  for (const int level : {0, 1}) {
    const std::string in = level == 0 ? "Level0" : "Level1";
    const Ints boxes = level == 0 ? Ints{0, 1, 0, 0, 0, 0} : fine_boxes;
    maker.group(in)
        .attribute(in, "Spacing", level == 0 ? Reals{1, 1, 1} : Reals{0.5, 0.5, 0.5})
        .ints(in + "/AMRBox", boxes, {boxes.size() / 6, 6})
        .group(in + "/" + data)
        .reals(in + "/" + data + "/c", level == 0 ? coarse : fine);
  }
}

TEST_F(VtkHdf, AdaptiveGridsAreBoxes) {
  VtkHdfMaker maker(path, "OverlappingAMR");
  add_levels(maker, "CellData", {1, 2}, counting<double>(8), {2, 3, 0, 1, 0, 0, 2, 3, 0, 1, 1, 1});
  maker.close();
  const Dataset dataset = read();
  ASSERT_EQ(dataset.kind, DatasetKind::kBoxes);
  EXPECT_EQ(dataset.num_positions(), 9);
  EXPECT_EQ(values_of<double>(dataset.array("c")), (Reals{1, 1, 2, 3, 4, 5, 6, 7, 8}));
  const Reals places = values_of<double>(dataset.positions);
  EXPECT_EQ(Reals(places.begin(), places.begin() + 6), (Reals{1.5, 0.5, 0.5, 2.25, 0.25, 0.25}));
  EXPECT_EQ(places.back(), 0.75);
}

TEST_F(VtkHdf, AdaptiveGridsOfNodes) {
  VtkHdfMaker maker(path, "OverlappingAMR");
  add_levels(maker, "PointData", counting<double>(12), counting<double>(18), {2, 3, 0, 1, 0, 0});
  maker.close();
  const Dataset dataset = read();
  ASSERT_EQ(dataset.kind, DatasetKind::kBoxes);
  // The finer box covers a half of the second cell, where its centre is not.
  EXPECT_EQ(dataset.num_positions(), 6);
  EXPECT_EQ(values_of<double>(dataset.array("c"))[0],
            6);  // of 1 2 4 5 7 8 10 11
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("mean of each cell's corners")));
}

TEST_F(VtkHdf, AdaptiveGridsHaveTime) {
  for (const bool is_older : {false, true}) {
    VtkHdfMaker maker(path, "OverlappingAMR", {2, is_older ? 2 : 3});
    const std::string end = is_older ? "" : "s";
    add_levels(maker, "CellData", {1, 2, 3, 4}, counting<double>(12),
               {2, 3, 0, 1, 0, 1, 2, 3, 0, 0, 0, 1});
    maker.group("Steps").attribute("Steps", "NSteps", Ints{2}).reals("Steps/Values", {0, 1});
    for (const int level : {0, 1}) {
      const std::string in = level == 0 ? "Steps/Level0" : "Steps/Level1";
      maker.group(in)
          .ints(in + "/AMRBoxOffset" + end, level == 0 ? Ints{0, 0} : Ints{0, 1})
          .ints(in + "/NumberOfAMRBox" + (is_older ? "" : "es"), Ints{1, 1})
          .group(in + "/CellDataOffset" + end)
          .ints(in + "/CellDataOffset" + end + "/c", level == 0 ? Ints{0, 2} : Ints{0, 8});
    }
    maker.close();
    const Dataset dataset = read(1);
    EXPECT_EQ(dataset.num_steps, 2);
    // The box of the second step covers half of the second cell: its centre is at the box's edge.
    const Reals values = values_of<double>(dataset.array("c"));
    EXPECT_EQ(values.front(), 3) << is_older;
    EXPECT_EQ(values.back(), 12);
    EXPECT_EQ(values_of<double>(read(0).array("c")).size(), 9U);
  }
}

TEST_F(VtkHdf, BlocksOfCollections) {
  for (const char* const type : {"PartitionedDataSetCollection", "MultiBlockDataSet"}) {
    VtkHdfMaker(path, type)
        .block("b0", "UnstructuredGrid")
        .tetrahedra("b0/", {0})
        .reals("b0/PointData/f", {1, 2, 3, 4})
        .block("b1", "UnstructuredGrid")
        .tetrahedra("b1/", {5, 7})
        .reals("b1/PointData/f", counting<double>(8))
        .block("trees", "HyperTreeGrid")
        .outside("far")
        .group("empty")
        .group("Assembly")
        .group("Assembly/outer")
        .link("Assembly/first", "/VTKHDF/b0")
        .link("Assembly/outer/second", "/VTKHDF/b1");
    const Dataset dataset = read();
    EXPECT_EQ(dataset.num_positions(), 12);
    ASSERT_EQ(dataset.blocks.size(), 2U);
    EXPECT_EQ(dataset.blocks[0].name, "first");
    EXPECT_EQ(dataset.blocks[1].name, "outer/second");
    EXPECT_THAT(dataset.notes, Contains(HasSubstr("block 'trees' is left out: it is of the Type "
                                                  "'HyperTreeGrid', which is not read")));
    EXPECT_THAT(dataset.notes, Contains(HasSubstr("block 'far' is left out: it lies in another")));
    EXPECT_EQ(read({}, "outer/second").num_positions(), 8);
  }
}

TEST_F(VtkHdf, ImagesOfCollectionsAreALattice) {
  VtkHdfMaker maker(path, "PartitionedDataSetCollection");
  maker.block("a", "ImageData")
      .image("a", {0, 2, 0, 1, 0, 0})
      .reals("a/PointData/f", {1, 2, 3, 11, 12, 13}, {2, 3})
      .block("b", "ImageData")
      .image("b", {2, 3, 0, 1, 0, 0})
      .reals("b/PointData/f", {3, 4, 13, 14}, {2, 2})
      .close();
  const Dataset dataset = read();
  ASSERT_EQ(dataset.kind, DatasetKind::kLattice);
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 2, 1}));
  EXPECT_EQ(values_of<double>(dataset.array("f")), (Reals{1, 2, 3, 4, 11, 12, 13, 14}));
}

TEST_F(VtkHdf, WhatIsWrongIsTold) {
  VtkHdfMaker(path, "HyperTreeGrid");
  EXPECT_THAT(error(), HasSubstr("has the Type 'HyperTreeGrid', which is not read"));
  VtkHdfMaker(path, "OverlappingAMR").attribute("", "Origin", Reals{0, 0, 0});
  EXPECT_THAT(error(), HasSubstr("a.vtkhdf: has no grids"));
  const auto mesh = [&](const std::function<void(VtkHdfMaker&)>& spoil) {
    {
      VtkHdfMaker maker(path, "UnstructuredGrid");
      maker.tetrahedra("", {0}).reals("PointData/f", counting<double>(8));
      spoil(maker);
    }
    return error_of([&] { read(1); });
  };
  const auto steps = [](const Ints& parts, const Ints& points, const Ints& cells) {
    return [=](VtkHdfMaker& maker) {
      maker.steps("", {0, 1}, parts, {1, 1}, points, cells, {0, 0});
    };
  };
  EXPECT_EQ(mesh([](VtkHdfMaker& maker) {
              maker.steps("", {0, 1}, {0, 0}, {1, 1}, {0, 0}, {0, 0}, {0, 0})
                  .ints("Steps/PointDataOffsets/f", {0, 4});
            }),
            "");
  EXPECT_THAT(mesh(steps({0, 1}, {0, 0}, {0, 0})),
              HasSubstr("step 1 has 1 parts from 1 on: the file has 1"));
  EXPECT_THAT(mesh(steps({0, 0}, {0, 4}, {0, 0})),
              HasSubstr("'/VTKHDF/Points' has 4 rows: 4 from 4 on are asked for"));
  EXPECT_THAT(mesh(steps({0, 0}, {0, 0}, {0, 1})),
              HasSubstr("'/VTKHDF/Offsets': part 0 of step 1 has no 2 offsets from 0 to 4"));
  EXPECT_THAT(mesh([](VtkHdfMaker& maker) {
                maker.steps("", {0, 1}, {0, 0}, {1, 1}, {0, 0}, {0, 0}, {0, 0})
                    .ints("Steps/PointDataOffsets/f", {0, 5});
              }),
              HasSubstr("'/VTKHDF/PointData/f' has 8 rows: 4 from 5 on are asked for"));
  EXPECT_THAT(
      mesh([](VtkHdfMaker& maker) { maker.group("Steps").attribute("Steps", "NSteps", Ints{2}); }),
      HasSubstr("dataset '/VTKHDF/Steps/PartOffsets' is missing"));
  VtkHdfMaker(path, "PartitionedDataSetCollection").outside("far");
  EXPECT_THAT(error(), HasSubstr("block 'far' is left out"));
}

// The library reads what the file says, in a process of its own; whatever that is, we return
// something consistent or throw a line.
TEST_F(VtkHdf, DamagedFiles) {
  OVOID_NOT_UNDER_TSAN();
  VtkHdfMaker(path, "UnstructuredGrid")
      .tetrahedra("", {0, 5})
      .reals("PointData/f", counting<double>(8))
      .steps("", {0, 1}, {0, 1}, {1, 1}, {0, 4}, {0, 1}, {0, 4});
  const std::string mesh = folder.read("a.vtkhdf");
  {
    VtkHdfMaker maker(path, "OverlappingAMR");
    add_levels(maker, "CellData", {1, 2}, counting<double>(8),
               {2, 3, 0, 1, 0, 0, 2, 3, 0, 1, 1, 1});
  }
  const std::string levels = folder.read("a.vtkhdf");
  VtkHdfMaker(path, "MultiBlockDataSet")
      .block("a", "ImageData")
      .image("a", {0, 2, 0, 1, 0, 0})
      .reals("a/PointData/f", {1, 2, 3, 11, 12, 13}, {2, 3})
      .group("Assembly")
      .link("Assembly/first", "/VTKHDF/a");
  const std::string blocks = folder.read("a.vtkhdf");
  const auto session = std::make_shared<ReaderSession>(std::vector{path});
  std::mt19937_64 random(20261129);
  for (int i = 0; i < 900; ++i) {
    std::string bytes = i % 3 == 0 ? mesh : i % 3 == 1 ? levels : blocks;
    for (std::size_t k = 1 + random() % 4; k > 0; --k)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    if (i % 10 == 0) bytes.resize(random() % bytes.size());
    ReadOptions options;
    options.session = session;
    folder.write("a.vtkhdf", bytes);
    fuzz::expect_dataset_or_error([&] {
      try {
        return read_dataset({path}, options);
      } catch (const Error& error) {
        EXPECT_LE(std::string(error.what()).size(), 1000U);
        throw;
      }
    });
  }
}

}  // namespace vtkhdf_test
}  // namespace ovoid::io
#else
namespace ovoid::io {
namespace vtkhdf_test {

TEST(VtkHdf, NeedsHdf5) {
  const TestFolder folder;
  const std::string path = folder.write("a.vtkhdf", "\x89HDF\r\n\x1a\n VTKHDF");
  EXPECT_THAT(error_of([&] { read_dataset({path}); }), testing::HasSubstr("HDF5"));
}

}  // namespace vtkhdf_test
}  // namespace ovoid::io
#endif
