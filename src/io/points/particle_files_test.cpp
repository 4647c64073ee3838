// SPDX-License-Identifier: Apache-2.0
// Particles of real simulations, where they lie beside the project.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace particle_files_test {

class ParticleFiles : public testing::Test {
 protected:
  // Reads it, or skips the test.
  void read(const std::string& name) {
    const char* const folder = std::getenv("OVOID_DATA");
    const std::filesystem::path base =
        folder != nullptr ? folder : std::filesystem::path(OVOID_SOURCE_DIR) / "../shared/data";
    if (!std::filesystem::exists(base / name))
      GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
    try {
      dataset_ = read_dataset({(base / name).string()});
    } catch (const Error& error) {
      if (std::string(error.what()).find("has no HDF5") == std::string::npos) throw;
      GTEST_SKIP() << error.what();
    }
    for (const DataArray& array : dataset_.arrays)
      EXPECT_EQ(array.num_tuples, dataset_.num_positions()) << array.name;
  }

  Dataset dataset_;
};

TEST_F(ParticleFiles, ZeldovichIsReadLineByLine) {
  read("zeldovich/zeldovich.csv.gz");
  if (IsSkipped()) return;
  EXPECT_EQ(dataset_.num_positions(), 27000);
  EXPECT_EQ(dataset_.arrays.size(), 6U);
  EXPECT_EQ(values_of<double>(dataset_.positions)[0], -5.111475982218680159);
  EXPECT_EQ(values_of<double>(dataset_.array("vx"))[0], -1.114759822186802210e-02);
}

TEST_F(ParticleFiles, WaterHasElevenSteps) {
  read("md_water/spce_all_coords.lammpstrj.bz2");
  if (IsSkipped()) return;
  EXPECT_EQ(dataset_.num_positions(), 4500);
  EXPECT_EQ(dataset_.num_steps, 11);
  EXPECT_EQ(values_of<double>(dataset_.positions)[0], 4.48355);
  ASSERT_TRUE(dataset_.periodic_box.has_value());
  EXPECT_EQ(dataset_.periodic_box->max()[0], 35.53280);
}

TEST_F(ParticleFiles, HaloHasPositionsOnly) {
  read("dm_halo/dm_halo.h5py");
  if (IsSkipped()) return;
  EXPECT_EQ(dataset_.num_positions(), 174312);
  EXPECT_TRUE(dataset_.arrays.empty());
}

TEST_F(ParticleFiles, SphHasMassAndDensity) {
  read("phantom_sph/adiabatic_00000.h5");
  if (IsSkipped()) return;
  EXPECT_EQ(dataset_.num_positions(), 20736);
  EXPECT_NEAR(values_of<float>(dataset_.array("mass"))[0], 2.6974e-6, 1e-9);
  EXPECT_EQ(dataset_.array("vxyz").num_components, 3);
}

}  // namespace particle_files_test
}  // namespace ovoid::io
