// SPDX-License-Identifier: Apache-2.0
// Meshes, particles and kernels on the command line. Fails if a flag does not reach the model, if a
// flag for another kind of data is taken without a word, or if poor data crash or draw nothing.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ovoid/io.h"
#include "ovoid/kernel_field.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "program.h"

namespace ovoid::cli_tests {
namespace kernel_data_test {

using nlohmann::json;

// 8 x 8 x 8 particles with a temperature that rises along x and a charge that falls along z.
std::string particle_rows(const std::string& first = {}) {
  std::string text = "x,y,z,temperature [K],charge,hsml\n" + first;
  char row[128];
  for (int k = 0; k < 8; ++k) {
    for (int j = 0; j < 8; ++j) {
      for (int i = 0; i < 8; ++i) {
        std::snprintf(row, sizeof(row), "%d,%d,%d,%d,%d,1.5\n", i, j, k, 100 + 10 * i, -k);
        text += row;
      }
    }
  }
  return text;
}

class KernelData : public testing::Test {
 protected:
  std::string particles() {
    const std::string path = folder_ / "particles.csv";
    write_file(path, particle_rows());
    return path;
  }
  std::string blobs() {
    const std::string path = folder_ / "blobs.ply";
    expect_success({"make", "blobs", "--count", "40", "-o", path});
    return path;
  }
  std::string rows(const std::string& name, const std::string& text) {
    write_file(folder_ / name, text);
    return folder_ / name;
  }

  std::string fin() {
    const std::string path = folder_ / "fin.vtu";
    expect_success({"make", "fin", "--count", "2000", "-o", path});
    return path;
  }

  Folder folder_;
};

// Columns of a CSV file with one line of names.
std::vector<std::vector<double>> read_rows(const std::string& path, std::string* names) {
  std::istringstream lines(read_file(path));
  std::getline(lines, *names);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

TEST_F(KernelData, ParticlesAndStoredKernelsAreDrawnWithoutFlags) {
  for (const std::string& path : {particles(), blobs()}) {
    EXPECT_GT(draw(folder_, {path}).num_covered(), 100U) << path;
    EXPECT_GT(draw(folder_, {path, "--backend", "reference"}).num_covered(), 100U) << path;
  }
}

TEST_F(KernelData, EveryFlagOfTheModelChangesThePicture) {
  const std::string path = particles();
  const auto base = draw(folder_, {path}).rgba;
  for (const Words& more : std::vector<Words>{
           {"--array", "charge"},
           {"--color-array", "charge"},
           {"--cutoff", "2"},
           {"--quantity", "density"},
           {"--radius-array", "temperature"},
           {"--anisotropic"},
           {"--profile-kernel", "epanechnikov"},
           {"--reconstruction", "sum"},
           {"--crop-world", "2:5,:,:"},
           {"--sampling-distance", "0.3"},
           {"--slab", "mean"},
           {"--view", "+x"},
       }) {
    Words words = {path};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_NE(draw(folder_, words).rgba, base) << joined(more);
  }
  const std::string bare = rows("bare.csv",
                                "x,y,z,v\n0,0,0,1\n1,0,0,2\n0,1,0,3\n0,0,1,4\n1,1,1,5\n"
                                "2,1,0,6\n1,2,1,7\n2,2,2,8\n");
  const auto of_bare = draw(folder_, {bare}).rgba;
  EXPECT_NE(draw(folder_, {bare, "--neighbors", "4"}).rgba, of_bare);
  EXPECT_NE(draw(folder_, {bare, "--neighborhood", "voronoi"}).rgba, of_bare);
  const Words density = {bare, "--quantity", "density"};
  const auto mass_of = [&](const Words& more) {
    Words words = density;
    words.insert(words.end(), more.begin(), more.end());
    return facts_of(words[0], {words.begin() + 1, words.end()})["field"]["range"][1].get<double>();
  };
  EXPECT_NEAR(mass_of({"--mass", "3"}), 3 * mass_of({}), 1e-4 * mass_of({}) + 1e-6);
  EXPECT_GT(mass_of({"--mass-array", "v"}), mass_of({}));
}

TEST_F(KernelData, FlagsForOtherDataAreRefusedByName) {
  const std::string csv = particles();
  const std::string ply = blobs();
  const std::string ball = write_ball(folder_);
  const std::string out = folder_ / "out.png";
  struct Case {
    std::string path;
    Words flag;
    std::string message;
  };
  for (const Case& c : std::vector<Case>{
           {csv,
            {"--kernel", "gaussian:1,3"},
            "--kernel: is for lattices, '" + csv + "' holds particles"},
           {csv, {"--prefilter"}, "--prefilter: is for lattices"},
           {csv, {"--crop", "0:1,,"}, "--crop: is for lattices"},
           {csv, {"--positions", "/a"}, "--positions: is for HDF5 files, '" + csv + "' is CSV"},
           {csv, {"--value", "/a"}, "--value: is for HDF5 files"},
           {csv, {"--time", "2"}, "--time: '" + csv + "' has one step"},
           {csv, {"--gradient", "exact"}, "gradient"},
           {csv, {"--gradient", "corrected"}, "gradient"},
           {ply,
            {"--quantity", "density"},
            "--quantity: is for particles, '" + ply + "' holds kernels"},
           {ply, {"--neighborhood", "voronoi"}, "--neighborhood: is for meshes and particles"},
           {ball,
            {"--color-array", "x"},
            "--color-array: is for meshes, particles and kernels, '" + ball + "' is a lattice"},
           {ball, {"--cutoff", "3"}, "--cutoff: is for"},
           {ball, {"--radius-array", "h"}, "--radius-array: is for particles"},
           {ball, {"--mass-array", "m"}, "--mass-array: is for particles"},
           {ball, {"--mass", "1"}, "--mass: is for particles"},
           {ball, {"--neighbors", "8"}, "--neighbors: is for particles"},
           {ball, {"--anisotropic"}, "--anisotropic: is for particles"},
           {ball, {"--profile-kernel", "gaussian"}, "--profile-kernel: is for particles"},
       }) {
    Words words = {"render", c.path, "-o", out};
    words.insert(words.end(), c.flag.begin(), c.flag.end());
    expect_failure(words, 1, {c.message});
    EXPECT_FALSE(std::filesystem::exists(out));
  }
}

TEST_F(KernelData, SpellingIsCheckedBeforeAnyFileIsRead) {
  const std::string out = folder_ / "out.png";
  const auto refused = [&](const Words& more, const std::string& message) {
    Words words = {"render", "nothing.csv", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    expect_failure(words, 2, {message});
  };
  refused({"--cutoff", "0.5"}, "--cutoff '0.5': expected");
  refused({"--neighbors", "3"}, "--neighbors '3': expected");
  refused({"--mass", "0"}, "--mass '0': expected");
  refused({"--quantity", "mass"}, "--quantity 'mass': expected one of attribute, density");
  refused({"--profile-kernel", "box"}, "--profile-kernel 'box': expected one of gaussian");
  refused({"--neighborhood", "near"}, "--neighborhood 'near': expected one of edges, voronoi");
  refused({"--mass", "1", "--mass-array", "m"}, "--mass: contradicts --mass-array");
  refused({"--time", "1", "--step", "2"}, "--time: contradicts --step");
  refused({"--quantity", "density", "--array", "v"},
          "--array: has no effect with --quantity density");
  refused({"--color-array", "v", "--mode", "xray"},
          "--color-array: has no effect with --mode xray");
}

TEST_F(KernelData, NotesSayWhatWasChosenAndCounted) {
  const Outcome drawn = run({"info", particles()});
  EXPECT_NE(drawn.err.find("note: array 'temperature' of temperature, charge, hsml"),
            std::string::npos)
      << drawn.err;
  const std::string holes = rows("holes.csv", particle_rows("nan,0,0,1,1,1\n1,1,1,nan,1,1\n"));
  const Outcome counted = run({"info", holes, "--array", "temperature"});
  EXPECT_NE(counted.err.find("1 of 514 particles without a finite value of 'temperature'"),
            std::string::npos)
      << counted.err;
  EXPECT_NE(counted.err.find("1 of 514 particles without a finite position"), std::string::npos)
      << counted.err;
}

TEST_F(KernelData, InfoTellsAllOfParticles) {
  const json told = facts_of(particles(), {"--color-array", "charge"});
  EXPECT_EQ(told["kind"], "particles");
  EXPECT_EQ(told["format"], "CSV");
  EXPECT_EQ(told["points"], 512);
  EXPECT_EQ(told["bounds"], json({{0, 0, 0}, {7, 7, 7}}));
  EXPECT_TRUE(told["periodic_box"].is_null());
  EXPECT_FALSE(told.contains("dims"));
  ASSERT_EQ(told["arrays"].size(), 3U);
  EXPECT_EQ(told["arrays"][0]["unit"], "K");
  const json& field = told["field"];
  EXPECT_EQ(field["array"], "temperature");
  EXPECT_EQ(field["color_array"], "charge");
  EXPECT_EQ(field["num_kernels"], 512);
  EXPECT_EQ(field["range"], json({100, 170}));
  EXPECT_EQ(field["color_range"], json({-7, 0}));
  EXPECT_EQ(field["shape"], "balls");
  EXPECT_EQ(field["profile"], "gaussian");
  EXPECT_EQ(field["reconstruction"], "normalized");
  for (const char* const count : {"missing", "misplaced", "merged", "dangling", "copies"})
    EXPECT_EQ(field[count], 0) << count;
  ASSERT_EQ(field["spacings"].size(), 5U);
  EXPECT_NEAR(field["spacings"][2].get<double>(), 1.5, 1e-5);  // twice h / 2
  EXPECT_EQ(field["axis_ratios"], json({1, 1, 1, 1, 1}));
  EXPECT_NEAR(field["constant"]["mean"].get<double>(), 1, 0.3);
  EXPECT_GE(field["constant"]["deviation"].get<double>(), 0);
  EXPECT_GT(field["memory_bytes"], 512 * 20);
  EXPECT_GT(field["default_sampling_distance"], 0);
}

TEST_F(KernelData, InfoTextAndJsonSayTheSame) {
  const Outcome text = run({"info", particles(), "--color-array", "charge"});
  for (const char* const part :
       {"kind                      particles", "points                    512, float",
        "bounds                    (0", "drawn array               'temperature', 100 to 170",
        "colour array              'charge', -7 to 0", "kernels                   512",
        "spacing of kernels        1.5, 1.5", "sum of weights            "}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << "\nnot in\n" << text.out;
  }
}

TEST_F(KernelData, InfoDescribesWhatCannotBeDrawn) {
  const std::string path = rows("negative.csv", "x,y,z,v,h\n0,0,0,1,1\n1,0,0,2,-3\n");
  const Outcome told = run({"info", path, "--json"});
  EXPECT_EQ(told.exit_code, 0) << told.err;
  EXPECT_TRUE(json::parse(told.out)["field"].is_null());
  EXPECT_NE(told.err.find("h[1] = -3: must be > 0: nothing can be drawn"), std::string::npos)
      << told.err;
  expect_failure({"info", path, "--radius-array", "h"}, 1, {"h[1] = -3: must be > 0"});
  expect_failure({"render", path, "-o", folder_ / "x.png"}, 1, {"h[1] = -3: must be > 0"});
}

TEST_F(KernelData, PoorDataAreDrawnOrRefusedInOneLine) {
  for (const char* const text :
       {"x,y,z,v\n1,2,3,4\n", "x,y,z,v\n0,0,0,1\n1,0,0,2\n",
        "x,y,z,v\n0,0,0,1\n1,1,1,2\n2,2,2,3\n3,3,3,4\n",           // on a line
        "x,y,z,v\n0,0,5,1\n1,0,5,2\n0,1,5,3\n1,1,5,4\n2,1,5,5\n",  // on a plane
        "x,y,z,v\n0,0,0,1\n0,0,0,2\n0,0,0,3\n1,0,0,4\n",           // duplicates
        "x,y,z,v\n2,2,2,1\n2,2,2,1\n2,2,2,1\n",                    // all at one place
        "x,y,z\n0,0,0\n1,0,0\n0,1,0\n0,0,1\n1,1,1\n",              // no array
        "x,y,z,v\n0,0,0,1\nnan,0,0,2\n0,1,0,3\ninf,1,1,4\n1,1,0,2\n"}) {
    const std::string path = rows("poor.csv", text);
    for (const Words& more :
         std::vector<Words>{{}, {"--anisotropic"}, {"--neighborhood", "voronoi"}}) {
      Words words = {"render", path, "-o", folder_ / "poor.npy", "--size", "40x30"};
      words.insert(words.end(), more.begin(), more.end());
      SCOPED_TRACE(text + joined(more));
      const Outcome drawn = run(words);
      if (drawn.exit_code == 0) {
        for (const float part : read_npy(folder_ / "poor.npy").rgba)
          ASSERT_TRUE(std::isfinite(part));
      } else {
        EXPECT_EQ(drawn.exit_code, 1);
        EXPECT_EQ(drawn.error_lines().size(), 1U) << drawn.err;
      }
    }
  }
  expect_failure({"render", rows("none.csv", "x,y,z,v\nnan,0,0,1\n"), "-o", folder_ / "x.png"}, 1,
                 {"none.csv", "no kernel"});
}

TEST_F(KernelData, ColoursAndTheirRangeAreTheColourArrays) {
  const std::string path = particles();
  // The opacity array's values are 100 and more: red shows only if colours follow the charge.
  const Words flags = {path,        "--color-array", "charge",    "--colormap", "-7,1,0,0,0,1,0,0",
                       "--opacity", "0:0.9,200:0.9", "--no-shade"};
  const Picture red = draw(folder_, flags);
  EXPECT_GT(red.num_covered(), 100U);
  for (std::size_t i = 0; i < red.rgba.size(); i += 4) {
    EXPECT_NEAR(red.rgba[i], red.rgba[i + 3], 1e-3);
    EXPECT_NEAR(red.rgba[i + 1], 0, 1e-3);
  }
  const Words gray = {path,   "--color-array", "charge",    "--colormap",
                      "gray", "--opacity",     "0:1,200:1", "--no-shade"};
  Words narrow = gray;
  narrow.insert(narrow.end(), {"--range", "-1000,-900"});  // all charges lie above: white
  const Picture white = draw(folder_, narrow);
  EXPECT_NE(white.rgba, draw(folder_, gray).rgba);
  EXPECT_EQ(white.num_covered(), draw(folder_, gray).num_covered());  // opacities stay
  for (std::size_t i = 0; i < white.rgba.size(); i += 4)
    EXPECT_NEAR(white.rgba[i], white.rgba[i + 3], 1e-3);
}

TEST_F(KernelData, OpacitiesFromZeroBeatALogarithmThatNobodyAskedFor) {
  const std::string path = folder_ / "galaxy.npz";
  expect_success({"make", "galaxy", "-o", path});
  const Words words = {"render",          path,     "--quantity", "density",   "-o",
                       folder_ / "g.npy", "--size", "40x30",      "--opacity", "0:0,0.001:0.9"};
  const Outcome drawn = run(words);
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_NE(drawn.err.find("note: --opacity begins at 0: drawn on a linear scale"),
            std::string::npos)
      << drawn.err;
  Words asked = words;
  asked.emplace_back("--log");
  expect_failure(asked, 2, {"--opacity: begins at 0, expected values > 0 with --log"});
}

TEST_F(KernelData, DensitiesAreColouredByTheOthersMean) {
  const std::string path = rows("two.csv", "x,y,z,m,v\n0,0,0,1,10\n1,0,0,3,20\n");
  const json field = facts_of(path, {"--quantity", "density", "--color-array", "v"})["field"];
  EXPECT_EQ(field["color_range"], json({10, 20}));
  const std::string points = rows("middle.csv", "x,y,z\n0.5,0,0\n");
  expect_success({"sample", path, "--points", points, "-o", folder_ / "s.csv", "--quantity",
                  "density", "--color-array", "v"});
  std::string names;
  const auto sampled = read_rows(folder_ / "s.csv", &names);
  EXPECT_NEAR(sampled.at(0).at(4), (1 * 10 + 3 * 20) / 4.0, 1e-4);  // both are equally near
}

TEST_F(KernelData, MarksAndDryRun) {
  expect_success({"render", particles(), "-o", folder_ / "marks.png", "--size", "160x120",
                  "--colorbar", "--axes", "--bounding-box", "--scale-bar", "--color-array",
                  "charge"});
  const Outcome told = run({"render", particles(), "--dry-run", "--size", "200x150"});
  EXPECT_EQ(told.exit_code, 0) << told.err;
  for (const char* const row : {"kernels", "memory of the field", "sampling distance",
                                "time of a frame", "greatest memory"})
    EXPECT_NE(told.out.find(row), std::string::npos) << told.out;
}

TEST_F(KernelData, CropsKeepWhatLiesInTheBox) {
  const std::string path = particles();
  const Words view = {"--view", "+z", "--projection", "parallel"};
  Words all = {path}, half = {path, "--crop-world", "3:,:,:"};
  all.insert(all.end(), view.begin(), view.end());
  half.insert(half.end(), view.begin(), view.end());
  EXPECT_GT(draw(folder_, half).num_covered(), 50U);
  expect_failure({"render", path, "-o", folder_ / "x.png", "--crop-world", "100:200,:,:"}, 1,
                 {"--crop-world x = 100:200: must meet the data"});
}

TEST_F(KernelData, SamplesAreTheSamplersOwn) {
  const std::string path = particles();
  const std::string points =
      rows("points.csv", "x,y,z\n3.5,3.5,3.5\n0.25,6.5,2\n7,7,7\n50,50,50\n");
  const std::string out = folder_ / "samples.csv";
  expect_success({"sample", path, "--points", points, "-o", out, "--color-array", "charge"});
  std::string names;
  const auto rows = read_rows(out, &names);
  EXPECT_EQ(names, "x,y,z,value,color_value,gx,gy,gz,weight,defined");
  ASSERT_EQ(rows.size(), 4U);
  KernelModelOptions model;
  model.color_array = "charge";
  const KernelSampler sampler(make_kernel_field(read_dataset({path}), model));
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 10U);
    const KernelSample at = sampler.at({row[0], row[1], row[2]});
    EXPECT_EQ(row[9], at.is_defined ? 1 : 0);
    EXPECT_DOUBLE_EQ(row[8], at.weight);
    if (!at.is_defined) {
      EXPECT_TRUE(std::isnan(row[3]));
      continue;
    }
    EXPECT_DOUBLE_EQ(row[3], at.value);
    EXPECT_DOUBLE_EQ(row[4], at.color_value);
    for (int a = 0; a < 3; ++a)
      EXPECT_DOUBLE_EQ(row[5 + static_cast<std::size_t>(a)], at.gradient[a]);
  }
  EXPECT_NEAR(rows[0][3], 135, 1e-6);
  EXPECT_NEAR(rows[0][5], 10, 1);  // kelvin per unit along x
  EXPECT_EQ(rows[3][9], 0);
}

TEST_F(KernelData, SamplesOfALatticeAreItsFields) {
  const std::string ramp = folder_ / "flat.nrrd";
  expect_success({"make", "flat", "--size", "16", "-o", ramp});
  const std::string points = rows("points.csv", "x,y,z\n0.1,-0.2,0.3\n9,9,9\n");
  expect_success({"sample", ramp, "--points", points, "-o", folder_ / "s.csv"});
  std::string names;
  const auto rows = read_rows(folder_ / "s.csv", &names);
  EXPECT_EQ(names, "x,y,z,value,gx,gy,gz,weight,defined");
  const FieldSampler sampler(make_lattice_field(read_dataset({ramp})));
  const FieldSample at = sampler.at({0.1, -0.2, 0.3});
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_DOUBLE_EQ(rows[0][3], at.value);
  EXPECT_NEAR(rows[0][7], 1, 1e-9);
  EXPECT_EQ(rows[0][8], 1);
  EXPECT_EQ(rows[1][8], 0);
}

TEST_F(KernelData, SampleRefusesWhatItCannotUse) {
  const std::string path = particles();
  const std::string out = folder_ / "s.csv";
  expect_failure({"sample", path, "-o", out}, 2, {"--points: none given"});
  expect_failure({"sample", path, "--points", path}, 2, {"--output: none given"});
  expect_failure({"sample", path, "--points", path, "-o", folder_ / "s.png"}, 2,
                 {".csv, .npz or .ply"});
  expect_failure({"sample", path, "--points", path, "-o", path}, 2, {"is an input"});
  expect_failure({"sample", path, "--points", write_ball(folder_), "-o", out}, 1,
                 {"--points:", "is a lattice, expected particles"});
  expect_failure({"sample", path, "--points", folder_ / "no.csv", "-o", out}, 1, {"no.csv"});
}

TEST_F(KernelData, ConvertResamplesToAGrid) {
  const std::string path = particles();
  const std::string grid = folder_ / "grid.nrrd";
  expect_success({"convert", path, "-o", grid, "--size", "16"});
  const Dataset read = read_dataset({grid});
  EXPECT_EQ(read.lattice.dims, (Index3{16, 16, 16}));
  const KernelField field = make_kernel_field(read_dataset({path}));
  const KernelSampler sampler(field);
  const DataArray& array = read.arrays.at(0);
  for (const std::int64_t i : {0, 5, 8}) {
    const Vec3 place = read.lattice.world_from_index * Vec3(static_cast<double>(i), 8, 4);
    float value = 0;
    std::memcpy(&value, array.bytes.view.data() + 4 * (i + 16 * (8 + 16 * 4)), 4);
    EXPECT_FLOAT_EQ(value, static_cast<float>(sampler.at(place).value));
  }
  const Bounds3 bounds = read.lattice.world_bounds();
  EXPECT_TRUE(bounds.isApprox(field.world_bounds(), 1e-9));
  EXPECT_GT(draw(folder_, {grid}).num_covered(), 100U);
  expect_success({"convert", path, "-o", grid, "--size", "4x5x6", "--threads", "1"});
  EXPECT_EQ(read_dataset({grid}).lattice.dims, (Index3{4, 5, 6}));
}

TEST_F(KernelData, ResamplingDoesNotDependOnThreads) {
  const std::string path = blobs();
  expect_success({"convert", path, "-o", folder_ / "a.npy", "--size", "12", "--threads", "1"});
  expect_success({"convert", path, "-o", folder_ / "b.npy", "--size", "12", "--threads", "3"});
  EXPECT_EQ(read_file(folder_ / "a.npy"), read_file(folder_ / "b.npy"));
}

TEST_F(KernelData, ConvertKeepsParticlesAndKernels) {
  const std::string path = particles();
  for (const char* const name : {"p.npz", "p.ply", "p.csv"}) {
    expect_success({"convert", path, "-o", folder_ / name});
    EXPECT_EQ(facts_of(folder_ / name)["points"], 512) << name;
    EXPECT_EQ(facts_of(folder_ / name)["kind"], "particles") << name;
    EXPECT_EQ(draw(folder_, {folder_ / name, "--array", "temperature"}).rgba,
              draw(folder_, {path, "--array", "temperature"}).rgba)
        << name;
  }
  const std::string ply = blobs();
  expect_success({"convert", ply, "-o", folder_ / "again.ply"});
  EXPECT_EQ(draw(folder_, {folder_ / "again.ply"}).rgba, draw(folder_, {ply}).rgba);
  expect_success({"convert", path, "-o", folder_ / "balls.ply", "--kernels"});
  EXPECT_EQ(facts_of(folder_ / "balls.ply")["kind"], "kernels");
}

TEST_F(KernelData, ConvertRefusesWhatHasNoEffect) {
  const std::string path = particles();
  const std::string ball = write_ball(folder_);
  expect_failure({"convert", path, "-o", folder_ / "x.ply", "--neighbors", "8"}, 2,
                 {"--neighbors: has no effect without --size"});
  expect_failure({"convert", path, "-o", folder_ / "x.csv", "--kernels"}, 2,
                 {"--kernels:", "holds no kernels"});
  expect_failure({"convert", path, "-o", folder_ / "x.ply", "--kernels", "--size", "4"}, 2,
                 {"--kernels: contradicts --size"});
  expect_failure({"convert", ball, "-o", folder_ / "x.ply", "--kernels"}, 1,
                 {"--kernels: is for meshes and particles"});
  expect_failure({"convert", path, "-o", folder_ / "x.nrrd"}, 1, {"--size"});
  expect_failure({"convert", path, "-o", folder_ / "x.nrrd", "--size", "0"}, 2, {"--size '0'"});
  expect_failure({"convert", path, "-o", folder_ / "x.nrrd", "--size", "4x4"}, 2, {"--size '4x4'"});
  expect_failure({"convert", path, "-o", folder_ / "x.nrrd", "--size", "4x4x9999"}, 2,
                 {"--size '4x4x9999'", "8192"});
}

TEST_F(KernelData, MakeWritesSetsOfTheirOwnSize) {
  expect_success({"make", "galaxy", "--count", "300", "-o", folder_ / "g.npz"});
  EXPECT_EQ(facts_of(folder_ / "g.npz")["points"], 300);
  expect_success({"make", "fin", "--count", "500", "-o", folder_ / "fin.vtu"});
  EXPECT_NE(read_file(folder_ / "fin.vtu").find("UnstructuredGrid"), std::string::npos);
  expect_failure({"make", "galaxy", "--size", "8", "-o", folder_ / "x.csv"}, 2, {"--size"});
  expect_failure({"make", "flat", "--count", "8", "-o", folder_ / "x.nrrd"}, 2, {"--count"});
  expect_failure({"make", "flat", "-o", folder_ / "x.vtu"}, 1, {"x.vtu", "holds a mesh"});
  expect_failure({"make", "fin", "-o", folder_ / "x.csv"}, 1, {"x.csv", "mesh"});
}

// Balls are opaque, and smaller ones cover less; meshes have none.
TEST_F(KernelData, ParticlesMayBeDrawnAsPoints) {
  const std::string galaxy = folder_ / "galaxy.npz";
  expect_success({"make", "galaxy", "--count", "300", "-o", galaxy});
  const auto covered = [&](const std::string& points) {
    const Picture picture = draw(folder_, {galaxy, points, "--fit", "box"});
    double sum = 0;
    for (std::size_t i = 3; i < picture.rgba.size(); i += 4) sum += picture.rgba[i];
    return sum;
  };
  EXPECT_GT(covered("--points"), 5);
  EXPECT_GT(covered("--points=100"), 1.5 * covered("--points"));
  const std::string out = folder_ / "x.png";
  expect_failure({"render", galaxy, "-o", out, "--points", "--mode", "xray"}, 2,
                 {"--points: is for --mode composite"});
  expect_failure({"render", galaxy, "-o", out, "--points=0"}, 2, {"--points"});
  const Outcome told = run({"render", galaxy, "--points", "--dry-run"});
  EXPECT_NE(told.out.find("300 points"), std::string::npos) << told.out << told.err;
  expect_success({"make", "ball", "--size", "8", "-o", folder_ / "ball.nrrd"});
  expect_failure({"render", folder_ / "ball.nrrd", "-o", out, "--points"}, 1,
                 {"--points: is for particles and kernels"});
}

// An opaque volume covers what the surface covers; walls stand around it; cuts have lids.
TEST_F(KernelData, MeshesEndAtTheirSurface) {
  const std::string fin = folder_ / "fin.vtu";
  expect_success({"make", "fin", "--count", "600", "-o", fin});
  if (run({"info", fin}).err.find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build reads no VTU";
  const auto picture = [&](const Words& more) {
    Words words = {fin, "--array", "density", "--fit", "box"};
    words.insert(words.end(), more.begin(), more.end());
    return draw(folder_, words).rgba;
  };
  const auto surface = picture({"--surface"});
  const auto volume = picture({"--surface=0", "--opacity", "0:1"});
  const auto cut = picture({"--clip", "1,0,0,0"});
  const auto seen_through = picture({"--surface=0.3"});
  ASSERT_EQ(surface.size(), volume.size());
  double covered = 0;
  double missing = 0;
  double cut_partly = 0;
  for (std::size_t i = 3; i < surface.size(); i += 4) {
    covered += surface[i];
    missing += std::abs(surface[i] - volume[i]);
    if (cut[i] > 0.01F && cut[i] < 0.2F) ++cut_partly;
    EXPECT_LE(seen_through[i], surface[i] + 1e-5F);
  }
  EXPECT_GT(covered, 100);
  EXPECT_LT(missing, 0.02 * covered);  // rays that pass through an edge meet next to nothing
  EXPECT_LT(cut_partly, 0.02 * covered);
  EXPECT_NE(seen_through, picture({"--surface=0"}));
}

TEST_F(KernelData, MeshesAreDescribedDrawnAndConverted) {
  const std::string fin = folder_ / "fin.vtu";
  expect_success({"make", "fin", "--count", "600", "-o", fin});
  if (run({"info", fin}).err.find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build reads no VTU";
  const json told = facts_of(fin);
  EXPECT_EQ(told["kind"], "mesh");
  EXPECT_EQ(told["cells"]["count"], told["cells"]["types"]["tetrahedron"]);
  EXPECT_TRUE(told["cells"]["dims"].is_null());
  EXPECT_EQ(told["field"]["shape"], "ellipsoids");
  EXPECT_EQ(told["field"]["num_kernels"], told["points"]);
  EXPECT_NEAR(told["field"]["constant"]["mean"].get<double>(), 1, 0.1);
  // The volume; of itself a mesh shows its surface.
  const Words volume = {"--array", "density", "--surface=0"};
  const auto draw_mesh = [&](const std::string& file, const Words& more) {
    Words words = {file};
    words.insert(words.end(), volume.begin(), volume.end());
    words.insert(words.end(), more.begin(), more.end());
    return draw(folder_, words).rgba;
  };
  const auto base = draw_mesh(fin, {});
  EXPECT_NE(draw_mesh(fin, {"--neighborhood", "voronoi"}), base);
  EXPECT_NE(draw_mesh(fin, {"--color-array", "pressure"}), base);
  const auto surface = draw(folder_, {fin, "--array", "density", "--surface"}).rgba;
  EXPECT_NE(surface, base);
  EXPECT_NE(draw(folder_, {fin, "--array", "density", "--surface=0.5"}).rgba, surface);
  EXPECT_NE(draw(folder_, {fin, "--array", "density", "--edges"}).rgba, surface);
  EXPECT_EQ(draw(folder_, {fin, "--array", "density"}).rgba, surface);
  EXPECT_EQ(draw(folder_, {fin, "--array", "density", "--opacity", "0:0.1"}).rgba,
            draw_mesh(fin, {"--opacity", "0:0.1"}));
  const std::string out = folder_ / "x.png";
  expect_failure({"render", fin, "-o", out, "--neighbors", "8"}, 1,
                 {"--neighbors: is for particles, '" + fin + "' is a mesh"});
  expect_failure({"render", fin, "-o", out, "--surface", "--mode", "xray"}, 2,
                 {"--surface: is for --mode composite"});
  expect_failure({"render", fin, "-o", out, "--surface=2"}, 2, {"--surface"});
  expect_failure({"render", fin, "-o", out, "--prefilter"}, 1, {"--prefilter: is for lattices"});
  expect_failure({"render", fin, "-o", out, "--color-array", "none"}, 1,
                 {"none", "density", "pressure"});

  expect_success({"convert", fin, "-o", folder_ / "again.vtu"});
  EXPECT_EQ(draw_mesh(folder_ / "again.vtu", {}), base);
  expect_success({"convert", fin, "-o", folder_ / "fin.ply", "--array", "density"});
  const json kernels = facts_of(folder_ / "fin.ply");
  EXPECT_EQ(kernels["kind"], "kernels");
  EXPECT_EQ(kernels["points"], told["points"]);
  EXPECT_EQ(kernels["arrays"][0]["name"], "density");
  // Inside of the mesh: kernels by themselves know nothing of its end.
  const Words inside = {"--crop-world", "0.5:2.5,1.5:3,1.5:3.5", "--fit", "box"};
  const auto with = [&](Words words) {
    words.insert(words.end(), inside.begin(), inside.end());
    return words;
  };
  const Picture same = draw(folder_, with({folder_ / "fin.ply", "--array", "density",
                                           "--reconstruction", "normalized", "--cutoff", "3.5"}));
  const auto expected = draw_mesh(fin, inside);
  double greatest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    greatest = std::max(greatest, std::abs(double{same.rgba[i]} - expected[i]));
  EXPECT_LT(greatest, 0.05);  // axes and rotations are rounded to float32
  expect_success({"convert", fin, "-o", folder_ / "fin.nrrd", "--array", "density", "--size", "8"});
  EXPECT_GT(draw(folder_, {folder_ / "fin.nrrd"}).num_covered(), 20U);
}

// Few kernels draw what the mesh's draw, without a flag: the file says how they are summed.

}  // namespace kernel_data_test
}  // namespace ovoid::cli_tests
