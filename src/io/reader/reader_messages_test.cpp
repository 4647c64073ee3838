// SPDX-License-Identifier: Apache-2.0
#include "io/reader/reader_messages.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace reader_messages_test {

using Json = nlohmann::json;

Dataset small_mesh() {
  Dataset dataset;
  dataset.source = "a.vtu";
  dataset.format = "VTU";
  dataset.kind = DatasetKind::kMesh;
  dataset.positions =
      make_array<double>("positions", ScalarType::kFloat64, {0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
  dataset.cells.types = {CellType::kTriangle};
  dataset.cells.offsets = {0, 3};
  dataset.cells.connectivity = {0, 1, 2};
  dataset.arrays = {make_array<float>("v", ScalarType::kFloat32, {1, 2, 3}),
                    make_array<std::int16_t>("w", ScalarType::kInt16, {4, 5, 6, 7, 8, 9}, 2)};
  dataset.arrays[0].unit = "K";
  dataset.arrays[1].value_scale = 0.5;
  dataset.blocks = {{"b", "a block"}};
  dataset.block = "b";
  dataset.num_steps = 3;
  dataset.step = 2;
  dataset.times = {0, 0.1, std::numeric_limits<double>::infinity()};
  dataset.time_unit = "s";
  dataset.notes = {"odd"};
  return dataset;
}

ReaderHost host_of(const std::string& file) { return {file, {file}, {}}; }

TEST(ReaderMessages, DatasetArrivesWhole) {
  const Dataset sent = small_mesh();
  const Dataset got = dataset_from_message(host_of("a.vtu"), to_message(sent));
  EXPECT_EQ(got.format, "VTU");
  EXPECT_EQ(got.kind, DatasetKind::kMesh);
  EXPECT_EQ(values_of<double>(got.positions), values_of<double>(sent.positions));
  EXPECT_EQ(got.cells.types, sent.cells.types);
  EXPECT_EQ(got.cells.offsets, sent.cells.offsets);
  EXPECT_EQ(got.cells.connectivity, sent.cells.connectivity);
  ASSERT_EQ(got.arrays.size(), 2U);
  EXPECT_EQ(got.arrays[0].unit, "K");
  EXPECT_EQ(got.arrays[1].value_scale, 0.5);
  EXPECT_EQ(got.arrays[1].num_components, 2);
  EXPECT_EQ(values_of<std::int16_t>(got.arrays[1]), values_of<std::int16_t>(sent.arrays[1]));
  EXPECT_EQ(got.blocks.at(0).description, "a block");
  EXPECT_EQ(got.block, "b");
  EXPECT_EQ(got.step, 2);
  EXPECT_EQ(got.times, sent.times);
  EXPECT_EQ(got.time_unit, "s");
  EXPECT_EQ(got.notes, sent.notes);
}

TEST(ReaderMessages, LatticeAndBoxArriveWhole) {
  Dataset sent;
  sent.lattice.dims = {3, 1, 2};
  sent.lattice.kind = LatticeKind::kBodyCentred;
  sent.lattice.world_from_index.linear() << 1, 2, 0, 0.1, 5, 0, 0, 0, -1.0 / 3;
  sent.lattice.world_from_index.translation() << 1e9, -2, 0.3;
  sent.space = Space::kLps;
  sent.arrays = {make_array<std::uint8_t>("v", ScalarType::kUInt8, counting<std::uint8_t>(6))};
  const Dataset got = dataset_from_message(host_of("a.h5"), to_message(sent));
  EXPECT_EQ(got.lattice.dims, sent.lattice.dims);
  EXPECT_EQ(got.lattice.kind, sent.lattice.kind);
  EXPECT_EQ(Mat3(got.lattice.world_from_index.linear()),
            Mat3(sent.lattice.world_from_index.linear()));
  EXPECT_EQ(Vec3(got.lattice.world_from_index.translation()),
            Vec3(sent.lattice.world_from_index.translation()));
  EXPECT_EQ(got.space, Space::kLps);
}

TEST(ReaderMessages, RequestArrivesWhole) {
  ReaderRequest sent;
  sent.format = "EnSight";
  sent.source = "a.case";
  sent.paths = {"a.case"};
  sent.folder = "/data";
  sent.options.array = "v";
  sent.options.step = -7;  // the reader is the one to refuse it
  sent.options.hdf5.values = {"/a", "/b"};
  sent.files = {"/data/a.case"};
  const ReaderRequest got = request_from_message(to_message(sent));
  EXPECT_EQ(got.format, sent.format);
  EXPECT_EQ(got.paths, sent.paths);
  EXPECT_EQ(got.options.step, -7);
  EXPECT_EQ(got.options.hdf5.values, sent.options.hdf5.values);
  EXPECT_EQ(got.files, sent.files);
  sent.options.step.reset();
  EXPECT_FALSE(request_from_message(to_message(sent)).options.step.has_value());
}

// Rows 3 to 6 of ten particles, as the second of three shares.
Dataset share_of_particles() {
  Dataset dataset;
  dataset.source = "a.h5";
  dataset.kind = DatasetKind::kParticles;
  dataset.positions = make_array<float>("positions", ScalarType::kFloat32, counting<float>(9), 3);
  dataset.arrays = {make_array<float>("v", ScalarType::kFloat32, {1, 2, 3})};
  dataset.share = DatasetShare{3, 10};
  return dataset;
}

ReaderHost host_of_share(const std::optional<RowShare>& share) {
  ReaderHost host = host_of("a.h5");
  host.options.share = share;
  return host;
}

TEST(ReaderMessages, ShareArrivesWhole) {
  ReaderRequest request;
  EXPECT_FALSE(request_from_message(to_message(request)).options.share.has_value());
  request.options.share = RowShare{1, 3};
  const ReaderRequest got = request_from_message(to_message(request));
  ASSERT_TRUE(got.options.share.has_value());
  EXPECT_EQ(got.options.share->number, 1);
  EXPECT_EQ(got.options.share->count, 3);
  const Dataset sent = share_of_particles();
  const Dataset arrived = dataset_from_message(host_of_share(RowShare{1, 3}), to_message(sent));
  ASSERT_TRUE(arrived.share.has_value());
  EXPECT_EQ(arrived.share->first, 3);
  EXPECT_EQ(arrived.share->total, 10);
}

TEST(ReaderMessages, ShareWithoutRowsArrives) {
  Dataset sent = share_of_particles();
  sent.positions = make_array<float>("positions", ScalarType::kFloat32, {}, 3);
  sent.arrays = {make_array<float>("v", ScalarType::kFloat32, {})};
  sent.share = DatasetShare{0, 2};
  const ReaderHost host = host_of_share(RowShare{0, 7});
  EXPECT_EQ(dataset_from_message(host, to_message(sent)).num_positions(), 0);
  const auto refusal = [&] {
    return error_of([&] { dataset_from_message(host, to_message(sent)); });
  };
  sent.arrays = {make_array<float>("v", ScalarType::kFloat32, {1})};
  EXPECT_EQ(refusal(), "file-format: a.h5: its reader sent 1 tuples for 0 places");
  sent.arrays.clear();
  sent.positions.num_components = 2;
  EXPECT_EQ(refusal(),
            "file-format: a.h5: its reader sent positions that are not three floating-point "
            "numbers each");
}

TEST(ReaderMessages, AnotherShareIsRefused) {
  const auto refusal = [](const std::optional<RowShare>& asked, const Dataset& sent) {
    return error_of([&] { dataset_from_message(host_of_share(asked), to_message(sent)); });
  };
  const std::string wrong = "file-format: a.h5: its reader sent ";
  Dataset sent = share_of_particles();
  EXPECT_EQ(refusal(RowShare{1, 3}, sent), "");
  EXPECT_EQ(refusal({}, sent), wrong + "a share instead of all");
  EXPECT_EQ(refusal(RowShare{0, 3}, sent), wrong + "3 rows from 3 of 10, which is another share");
  sent.share->total = 13;
  EXPECT_EQ(refusal(RowShare{1, 3}, sent), wrong + "3 rows from 3 of 13, which is another share");
  sent.share->total = 0;
  EXPECT_EQ(refusal(RowShare{1, 3}, sent), wrong + "3 rows from 3 of 0, which is another share");
  sent.share = DatasetShare{2, 10};
  EXPECT_EQ(refusal(RowShare{1, 3}, sent), wrong + "3 rows from 2 of 10, which is another share");
  sent.share.reset();
  EXPECT_EQ(refusal(RowShare{1, 3}, sent), wrong + "all rows instead of a share");
  EXPECT_EQ(refusal({}, sent), "");
}

TEST(ReaderMessages, SharesOfMeshesArriveWithTheirNodes) {
  const auto refusal = [](const Dataset& sent) {
    return error_of([&] { dataset_from_message(host_of_share(RowShare{1, 3}), to_message(sent)); });
  };
  Dataset sent = share_of_particles();
  sent.kind = DatasetKind::kMesh;
  sent.cells.types = {CellType::kTriangle};
  sent.cells.offsets = {0, 3};
  sent.cells.connectivity = {0, 1, 2};
  sent.share = DatasetShare{4, 6, {1, 5, 7}};
  const Dataset arrived = dataset_from_message(host_of_share(RowShare{1, 3}), to_message(sent));
  EXPECT_EQ(arrived.share->nodes, sent.share->nodes);
  const std::string wrong = "file-format: a.h5: its reader sent ";
  sent.share = DatasetShare{4, 6, {1, 5}};
  EXPECT_EQ(refusal(sent), wrong + "nodes of a share without their numbers in the whole");
  sent.share = DatasetShare{4, 6, {1, 7, 5}};
  EXPECT_EQ(refusal(sent), wrong + "nodes of a share without their numbers in the whole");
  sent.share = DatasetShare{6, 6, {1, 5, 7}};
  EXPECT_EQ(refusal(sent), wrong + "1 cells from 6 of 6");
}

TEST(ReaderMessages, OtherProtocolIsRefused) {
  Json json = Json::from_msgpack(to_message(ReaderRequest{}));
  json["protocol"] = kReaderProtocol + 1;
  EXPECT_NE(error_of([&] { request_from_message(Json::to_msgpack(json)); }).find("another version"),
            std::string::npos);
}

// What a reader that was taken over may send.
TEST(ReaderMessages, NonsenseIsRefused) {
  const auto refusal = [](const std::function<void(Json&)>& spoil) {
    DatasetMessage message = to_message(small_mesh());
    Json json = Json::from_msgpack(message.description);
    spoil(json);
    message.description = Json::to_msgpack(json);
    return error_of([&] { dataset_from_message(host_of("a.vtu"), message); });
  };
  EXPECT_EQ(refusal([](Json&) {}), "");
  const std::vector<std::function<void(Json&)>> spoils{
      [](Json& j) { j.erase("cells"); },
      [](Json& j) { j["kind"] = 17; },
      [](Json& j) { j["kind"] = "mesh"; },
      [](Json& j) { j["num_steps"] = 0; },
      [](Json& j) { j["step"] = 3; },
      [](Json& j) { j["arrays"][0]["at"][0] = 1 << 20; },
      [](Json& j) { j["arrays"][0]["at"][0] = 3; },
      [](Json& j) { j["arrays"][0]["at"][1] = std::int64_t{1} << 60; },
      [](Json& j) { j["arrays"][0]["at"][1] = -4; },
      [](Json& j) { j["arrays"][0]["tuples"] = 4; },
      [](Json& j) { j["arrays"][0]["components"] = std::int64_t{1} << 33; },
      [](Json& j) { j["arrays"][0]["type"] = 200; },
      [](Json& j) { j["cells"]["connectivity"] = j["cells"]["types"]; },
      [](Json& j) { j["cells"]["connectivity"] = j["positions"]["at"]; },
      [](Json& j) { j["cells"]["types"] = j["arrays"][1]["at"]; },
      [](Json& j) {
        j["positions"]["components"] = 1;
        j["positions"]["tuples"] = 9;
      },
      [](Json& j) {
        j["lattice"]["dims"] = Json::array({1, 2});
      },
      [](Json& j) { j["kind"] = 0; },
  };
  for (std::size_t i = 0; i < spoils.size(); ++i) {
    const std::string message = refusal(spoils[i]);
    EXPECT_TRUE(message.starts_with("file-format: a.vtu: ")) << i << ": " << message;
  }
  EXPECT_NE(error_of([] { error_from_message({1, 2, 3}); }), "");
}

// Memory that could be taken away, or changed after it was checked.
TEST(ReaderMessages, UnsealedMemoryIsRefused) {
  DatasetMessage message = to_message(small_mesh());
  const off_t size = ::lseek(message.memory.get(), 0, SEEK_END);
  message.memory = UniqueFd(::memfd_create("loose", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  ASSERT_EQ(::ftruncate(message.memory.get(), size), 0);
  EXPECT_EQ(error_of([&] { dataset_from_message(host_of("a.vtu"), message); }),
            "file-format: a.vtu: its reader sent memory that is not sealed");
  message.memory = UniqueFd();
  EXPECT_NE(error_of([&] { dataset_from_message(host_of("a.vtu"), message); }), "");
}

}  // namespace reader_messages_test
}  // namespace ovoid::io
