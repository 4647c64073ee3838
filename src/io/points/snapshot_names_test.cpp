// SPDX-License-Identifier: Apache-2.0
#include "io/points/snapshot_names.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "io/core/test_folder.h"

namespace ovoid::io {
namespace snapshot_names_test {

TEST(SnapshotNames, NumberIsTheLastWordOrTheOneBefore) {
  const auto part = snapshot_part("run.1/snap_000.12.hdf5");
  ASSERT_TRUE(part.has_value());
  EXPECT_EQ(part->stem, "run.1/snap_000");
  EXPECT_EQ(part->number, 12);
  EXPECT_EQ(part->ending, ".hdf5");
  EXPECT_EQ(part->path(3), "run.1/snap_000.3.hdf5");
  EXPECT_EQ(snapshot_part("snap_000.0")->ending, "");
  for (const char* const other : {"snap_000.hdf5", "snap.001.hdf5", "run.1/snap.hdf5", ".0.hdf5",
                                  "snap.a.hdf5", "snap.1.2.3x.4x.hdf5", "", "0", "snap."})
    EXPECT_FALSE(snapshot_part(other).has_value()) << other;
}

// Fails if a link out of the folder is taken for a part: the reader must not be led elsewhere.
TEST(SnapshotNames, SiblingsLieInTheFolder) {
  const TestFolder folder;
  for (const char* const name : {"a.0.h5", "a.1.h5", "a.10.h5", "a.01.h5", "b.2.h5", "a.3.txt"})
    folder.write(name, "x");
  std::filesystem::create_symlink("/etc/hostname", folder.file("a.4.h5"));
  std::filesystem::create_directory(folder.file("a.5.h5"));
  EXPECT_EQ(snapshot_siblings(*open_file(folder.file("a.0.h5"))),
            (std::vector<std::string>{folder.file("a.1.h5"), folder.file("a.10.h5")}));
  EXPECT_TRUE(snapshot_siblings(*open_file(folder.file("a.01.h5"))).empty());
}

}  // namespace snapshot_names_test
}  // namespace ovoid::io
