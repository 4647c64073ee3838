// SPDX-License-Identifier: Apache-2.0
// Devices on the command line: what there is, what is asked for in vain, and what draws instead.
#include "program.h"
#include "team.h"

namespace ovoid::cli_tests {
namespace devices_test {

// For the programs that it starts.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

class Devices : public ::testing::Test {
 protected:
  Devices() {
    expect_success({"make", "marschner-lobb", "--size", "12", "-o", volume_});
    const Outcome listed = run({"info", "--devices", "--json"});
    const auto json = nlohmann::json::parse(listed.out);
    for (const auto& device : json[0]["devices"]) {
      ++num_devices_;
      has_usable_ = has_usable_ || device["lack"].is_null();
    }
  }

  Words render(const Words& flags) const {
    Words words{"render", volume_, "-o", picture_, "--size", "16x12"};
    words.insert(words.end(), flags.begin(), flags.end());
    return words;
  }

  Folder folder_;
  std::string volume_ = folder_ / "volume.nrrd";
  std::string picture_ = folder_ / "picture.npy";
  int num_devices_ = 0;
  bool has_usable_ = false;
};

// Those that draw by themselves, and can; where there are not several the usual one.
TEST(DevicesOfATeam, AreTakenInTurns) {
  DeviceList list;
  const auto add = [&](DeviceKind kind, const char* lack) {
    DeviceInfo& device = list.devices.emplace_back();
    device.index = static_cast<int>(list.devices.size()) - 1;
    device.kind = kind;
    device.lack = lack;
  };
  add(DeviceKind::kSoftware, "");
  add(DeviceKind::kDiscrete, "");
  EXPECT_EQ(cli::device_at_place(list, 0), -1);
  EXPECT_EQ(cli::device_at_place(list, 5), -1);
  add(DeviceKind::kDiscrete, "an extension");
  add(DeviceKind::kIntegrated, "");
  for (int place = 0; place < 5; ++place)
    EXPECT_EQ(cli::device_at_place(list, place), place % 2 == 0 ? 1 : 3);
}

TEST_F(Devices, AreListedForPeopleToo) {
  const Outcome listed = run({"info", "--devices"});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_NE(listed.out.find("cpu         SIMD targets"), std::string::npos) << listed.out;
  EXPECT_NE(listed.out.find(num_devices_ > 0 ? "vulkan      device 0: " : "vulkan      none: "),
            std::string::npos)
      << listed.out;
}

// Fails if the program needs the loader to start, or does not say what is wrong and what else there
// is.
TEST_F(Devices, WithoutALoaderTheRestWorks) {
  const Environment none("OVOID_VULKAN_LOADER", "/nowhere/libvulkan.so.1");
  const Outcome listed = run({"info", "--devices"});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_NE(listed.out.find("vulkan      none: "), std::string::npos) << listed.out;
  expect_success(render({}));
  const bool is_built = listed.out.find("without Vulkan") == std::string::npos;
  expect_failure(render({"--backend", "vulkan"}), 1,
                 {"backend vulkan", is_built ? "vulkan.loader = /nowhere" : "built without"});
}

TEST_F(Devices, WithoutADriverThereIsOneLine) {
  if (num_devices_ == 0) GTEST_SKIP() << "no device that could be hidden";
  const Environment hidden("VK_DRIVER_FILES", "/nowhere.json");
  const Environment hidden_for_older_loaders("VK_ICD_FILENAMES", "/nowhere.json");
  expect_failure(render({"--backend", "vulkan"}), 1, {"backend vulkan", "no Vulkan"});
  expect_success(render({}));
}

// Fails if a device is asked for and something else draws without a word.
TEST_F(Devices, AreRefusedWhereNoneDraws) {
  for (const std::string backend : {"cpu", "reference"}) {
    expect_failure(render({"--backend", backend, "--device", "5"}), 1,
                   {"device = 5: is for backend vulkan, not " + backend});
  }
  const Environment none("OVOID_VULKAN_LOADER", "/nowhere/libvulkan.so.1");
  expect_failure(render({"--device", "5"}), 1, {"device = 5: there is none", "leave it out"});
}

TEST_F(Devices, IndicesOutOfRangeAreNamed) {
  if (num_devices_ == 0) GTEST_SKIP() << "no device";
  expect_failure(render({"--backend", "vulkan", "--device", std::to_string(num_devices_)}), 1,
                 {"device = ", "expected 0 to " + std::to_string(num_devices_ - 1)});
  expect_failure(render({"--backend", "vulkan", "--device", "-1"}), 2, {"--device"});
}

// Fails if a device that cannot draw leaves nothing, or is kept quiet about.
TEST_F(Devices, AutoDrawsByTheCpuWhatTheDeviceCannot) {
  if (!has_usable_) GTEST_SKIP() << "no usable device";
  expect_success(render({"--backend", "cpu"}));
  const std::string by_cpu = read_file(picture_);
  const Environment takes("OVOID_AUTO_DEVICE", "any");
  const Outcome result = run(render({"--device-memory", "64"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("drawn by backend cpu"), std::string::npos) << result.err;
  EXPECT_EQ(read_file(picture_), by_cpu);
}

TEST_F(Devices, DrawTheSameBytesTwice) {
  if (!has_usable_) GTEST_SKIP() << "no usable device";
  expect_success(render({"--backend", "vulkan"}));
  const std::string first = read_file(picture_);
  expect_success(render({"--backend", "vulkan"}));
  EXPECT_EQ(read_file(picture_), first);
}

}  // namespace devices_test
}  // namespace ovoid::cli_tests
