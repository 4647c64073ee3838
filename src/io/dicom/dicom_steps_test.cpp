// SPDX-License-Identifier: Apache-2.0
// Series whose frames lie at the same places several times. What would make these fail: times that
// are volumes of their own, steps of slices of several times, echoes as steps, or a volume that is
// not whole among those that are.
#include "io/dicom/dicom_steps.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "io/core/test_folder.h"
#include "io/dicom/dicom_values.h"
#include "io/dicom/test_dicom_series.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace dicom_steps_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// What a slice of a series says besides.
using Change = std::function<void(TestSlice&, int time, int place)>;

// Writes `num_times` volumes of four slices, all but those that `is_there` leaves out.
void write_series(const TestFolder& folder, int num_times, const Change& change,
                  const std::function<bool(int, int)>& is_there = nullptr) {
  for (int time = 0; time < num_times; ++time) {
    for (int place = 0; place < 4; ++place) {
      if (is_there && !is_there(time, place)) continue;
      TestSlice slice = slice_in_time(time, place);
      change(slice, time, place);
      // Names are in no order of the series.
      folder.write(fmt::format("{}{}", (place * 7 + time * 5) % 11, slice.sop), dicom_slice(slice));
    }
  }
}

Dataset read_step(const TestFolder& folder, std::int64_t step, const std::string& block = {}) {
  ReadOptions options;
  options.step = step;
  options.block = block;
  return read_dataset({folder.file("")}, options);
}

// The first sample of each slice says whose it is.
std::vector<int> first_samples(const Dataset& dataset) {
  const std::vector<double> values = [&] {
    const DataArray& array = dataset.arrays.at(0);
    if (array.type == ScalarType::kFloat32) {
      const auto all = values_of<float>(array);
      return std::vector<double>(all.begin(), all.end());
    }
    const auto all = values_of<std::uint16_t>(array);
    return std::vector<double>(all.begin(), all.end());
  }();
  std::vector<int> firsts;
  for (std::size_t i = 0; i < values.size(); i += 6) firsts.push_back(static_cast<int>(values[i]));
  return firsts;
}

void expect_steps(const TestFolder& folder, int num_times) {
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.blocks, IsEmpty());
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 4));
  ASSERT_EQ(dataset.num_steps, num_times);
  for (int time = 0; time < num_times; ++time) {
    const int first = 100 * time + 1;
    EXPECT_THAT(first_samples(read_step(folder, time)),
                ElementsAre(first, first + 10, first + 20, first + 30));
  }
}

TEST(DicomSteps, InstanceNumbersOrderVolumes) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(4 * time + place + 1);
  });
  expect_steps(folder, 3);
}

TEST(DicomSteps, InstanceNumbersOrderTimesOfEachPlace) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(3 * place + time + 1);
  });
  expect_steps(folder, 3);
}

TEST(DicomSteps, RepetitionTimeIsTheTimeOfAVolume) {
  const TestFolder folder;
  const auto change = [](const char* acquisition) {
    return [acquisition](TestSlice& slice, int time, int place) {
      slice.instance = std::to_string(4 * time + place + 1);
      slice.groups.text(0x00180023, "CS", acquisition).text(0x00180080, "DS", "2000");
    };
  };
  write_series(folder, 3, change("2D"));
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.times, ElementsAre(0, 2000, 4000));
  EXPECT_EQ(dataset.time_unit, "ms");
  // Of a volume that is excited as a whole it is the time of one line.
  write_series(folder, 3, change("3D"));
  EXPECT_THAT(read_dataset({folder.file("")}).times, IsEmpty());
}

// Each slice has a time of its own, later in each volume; numbers say something else.
TEST(DicomSteps, TimesOfAcquisitionOrder) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(99 - 4 * time - place);
    slice.groups.text(0x00080022, "DA", time == 2 ? "20240301" : "20240229")
        .text(0x00080032, "TM",
              fmt::format("{}.{}00000", time == 2 ? "000002" : fmt::format("2359{}", 56 + 3 * time),
                          place));
  });
  expect_steps(folder, 3);
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.times, ElementsAre(0, 3, 6));  // over midnight
  EXPECT_EQ(dataset.time_unit, "s");
}

TEST(DicomSteps, TimesOfContentOrderWhatHasNoOthers) {
  const TestFolder folder;
  write_series(folder, 2, [](TestSlice& slice, int time, int) {
    slice.groups.text(0x00080033, "TM", time == 0 ? "10:20:30" : "10:20:31.5");
  });
  expect_steps(folder, 2);
}

TEST(DicomSteps, TemporalPositionsOrder) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(99 - 4 * time - place);
    slice.temporal_position = std::to_string(time + 1);
    slice.groups.text(0x00200110, "DS", "1500");
  });
  expect_steps(folder, 3);
  EXPECT_THAT(read_dataset({folder.file("")}).times, ElementsAre(0, 1500, 3000));
}

TEST(DicomSteps, NumbersOfAcquisitionsAreSteps) {
  const TestFolder folder;
  write_series(folder, 2, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(50 - 4 * time - place);
    slice.groups.text(0x00200012, "IS", std::to_string(time + 1));
  });
  expect_steps(folder, 2);
}

// The heart beats a little faster at some slices.
TEST(DicomSteps, TriggerTimesMayDifferBetweenSlices) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(99 - 4 * time - place);
    slice.trigger_time = std::to_string(40 * time + time * place);
  });
  expect_steps(folder, 3);
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_THAT(dataset.times, ElementsAre(0, 40, 80));
  EXPECT_EQ(dataset.time_unit, "ms");
}

TEST(DicomSteps, EchoesAreVolumesOfManyTimes) {
  for (const bool has_numbers : {true, false}) {
    const TestFolder folder;
    write_series(folder, 4, [&](TestSlice& slice, int time, int place) {
      slice.instance = std::to_string(4 * time + place + 1);
      slice.echo_time = time % 2 == 0 ? "4.92" : "7.38";
      if (has_numbers) slice.groups.text(0x00180086, "IS", time % 2 == 0 ? "1" : "2");
    });
    const Dataset dataset = read_dataset({folder.file("")});
    ASSERT_EQ(dataset.blocks.size(), 2U);
    EXPECT_EQ(dataset.blocks[0].name, "4");
    EXPECT_THAT(dataset.blocks[0].description, HasSubstr("2 time steps"));
    EXPECT_THAT(dataset.blocks[0].description, HasSubstr("echo 1 (4.92 ms)"));
    EXPECT_EQ(dataset.blocks[1].name, "4.2");
    EXPECT_THAT(dataset.blocks[1].description, HasSubstr("echo 2 (7.38 ms)"));
    EXPECT_EQ(dataset.num_steps, 2);
    EXPECT_THAT(first_samples(read_step(folder, 1)), ElementsAre(201, 211, 221, 231));
    EXPECT_THAT(first_samples(read_step(folder, 1, "4.2")), ElementsAre(301, 311, 321, 331));
  }
}

TEST(DicomSteps, MagnitudeAndPhaseAreVolumes) {
  const TestFolder folder;
  write_series(folder, 2, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(4 * time + place + 1);
    slice.groups.text(0x00080008, "CS",
                      time == 0 ? "ORIGINAL\\PRIMARY\\M\\ND" : "ORIGINAL\\PRIMARY\\P\\ND");
  });
  const Dataset dataset = read_dataset({folder.file("")});
  ASSERT_EQ(dataset.blocks.size(), 2U);
  EXPECT_THAT(dataset.blocks[0].description, testing::EndsWith(", M"));
  EXPECT_THAT(dataset.blocks[1].description, testing::EndsWith(", P"));
}

TEST(DicomSteps, DiffusionWeightingsAreSteps) {
  const TestFolder folder;
  const char* const weights[] = {"0", "500", "1000"};
  // At the upper places the weightings were taken in another order.
  write_series(folder, 3, [&](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(3 * place + (place < 2 ? time : 2 - time) + 1);
    slice.groups.raw(0x00189087, "FD", double_bytes(std::stod(weights[time])));
  });
  expect_steps(folder, 3);
  EXPECT_THAT(read_dataset({folder.file("")}).notes,
              Contains(HasSubstr("diffusion weightings, b = 0, 500, 1000 s/mm^2")));
}

TEST(DicomSteps, PrivateDiffusionWeightings) {
  const Change changes[] = {
      [](TestSlice& slice, int time, int) {
        slice.groups.text(0x00190010, "LO", "SIEMENS MR HEADER")
            .text(0x0019100C, "IS", std::to_string(800 * time));
      },
      [](TestSlice& slice, int time, int) {
        slice.groups.text(0x00430010, "LO", "GEMS_PARM_01")
            .text(0x00431039, "IS", fmt::format("{}\\8\\0\\0", 1000000000 + 800 * time));
      },
      [](TestSlice& slice, int time, int) {
        const float b = 800.0F * static_cast<float>(time);
        slice.groups.text(0x20010011, "LO", "Philips Imaging DD 001")
            .raw(0x20011103, "FL", {reinterpret_cast<const char*>(&b), sizeof b});
      }};
  for (const Change& change : changes) {
    const TestFolder folder;
    write_series(folder, 2, [&](TestSlice& slice, int time, int place) {
      slice.instance = std::to_string(4 * time + place + 1);
      change(slice, time, place);
    });
    EXPECT_THAT(read_dataset({folder.file("")}).notes, Contains(HasSubstr("b = 0, 800 s/mm^2")));
  }
}

TEST(DicomSteps, AVolumeThatIsNotWholeIsLeftOut) {
  // By numbers through volumes, by numbers through times, by a value.
  const Change changes[] = {[](TestSlice& slice, int time, int place) {
                              slice.instance = std::to_string(4 * time + place + 1);
                            },
                            [](TestSlice& slice, int time, int place) {
                              slice.instance = std::to_string(3 * place + time + 1);
                            },
                            [](TestSlice& slice, int time, int) {
                              slice.groups.text(0x00200012, "IS", std::to_string(time + 1));
                            }};
  for (const int incomplete : {2, 1}) {
    for (const Change& change : changes) {
      const TestFolder folder;
      write_series(folder, 3, change,
                   [&](int time, int place) { return time != incomplete || place < 2; });
      const Dataset dataset = read_dataset({folder.file("")});
      EXPECT_EQ(dataset.num_steps, 2);
      EXPECT_THAT(dataset.blocks, IsEmpty());
      EXPECT_THAT(
          dataset.notes,
          Contains(HasSubstr(fmt::format("volume {} of 3 in time lacks 2 of 4 slices: it is "
                                         "left out",
                                         incomplete + 1))));
      const int last = incomplete == 2 ? 101 : 201;
      EXPECT_THAT(first_samples(read_step(folder, 1)),
                  ElementsAre(last, last + 10, last + 20, last + 30));
    }
  }
}

TEST(DicomSteps, AStraySliceDoesNotSpoilASeries) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(4 * time + place + 1);
  });
  folder.write("stray", dicom_slice(slice_in_time(0, 9)));
  expect_steps(folder, 3);
  EXPECT_THAT(read_dataset({folder.file("")}).notes, Contains(HasSubstr("1 slice is left out")));
}

// Two slabs of one series that overlap are no two times.
TEST(DicomSteps, OverlappingSlabsAreVolumes) {
  const TestFolder folder;
  write_series(folder, 2, [](TestSlice& slice, int time, int place) {
    slice.groups.text(0x00200012, "IS", std::to_string(time + 1));
    slice.position = fmt::format("-10\\20\\{}", 3 * (place + 2 * time));
  });
  const Dataset dataset = read_dataset({folder.file("")});
  ASSERT_EQ(dataset.blocks.size(), 2U);
  EXPECT_THAT(first_samples(dataset), ElementsAre(1, 11, 21, 31));
  EXPECT_THAT(first_samples(read_step(folder, 0, "4.2")), ElementsAre(101, 111, 121, 131));
}

// The second slab begins where the first ends: one volume, and the slice that is double.
TEST(DicomSteps, SlabsThatShareASliceAreOneVolume) {
  const TestFolder folder;
  write_series(folder, 2, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(4 * time + place + 1);
    slice.groups.text(0x00200012, "IS", std::to_string(time + 1));
    slice.position = fmt::format("-10\\20\\{}", 3 * (place + 3 * time));
  });
  const Dataset dataset = read_dataset({folder.file("")});
  EXPECT_EQ(dataset.blocks.size(), 2U);
  EXPECT_THAT(first_samples(dataset), ElementsAre(1, 11, 21, 31, 111, 121, 131));
}

TEST(DicomSteps, TemporalPositionsOrderWhatHasNoPlace) {
  const TestFolder folder;
  write_series(folder, 3, [](TestSlice& slice, int time, int place) {
    slice.instance = std::to_string(3 * place + time + 1);
    slice.position.clear();
    slice.temporal_position = std::to_string(time + 1);
  });
  expect_steps(folder, 3);
}

TEST(DicomValues, DatesAndTimes) {
  EXPECT_EQ(dicom_time_seconds("102030.25"), 37230.25);
  EXPECT_EQ(dicom_time_seconds("10:20:30.5 "), 37230.5);
  EXPECT_EQ(dicom_time_seconds("1020"), 37200);
  EXPECT_EQ(dicom_time_seconds("10"), 36000);
  for (const char* text : {"", "1", "ab", "102030,5", "10203", "102030.x"})
    EXPECT_FALSE(dicom_time_seconds(text)) << text;
  EXPECT_EQ(dicom_date_seconds("19700102"), 86400);
  EXPECT_EQ(dicom_date_seconds("1970.01.02"), 86400);
  EXPECT_FALSE(dicom_date_seconds("19701302"));
  EXPECT_EQ(dicom_date_time_seconds("19700102000001.5+0100"), 86401.5);
  EXPECT_FALSE(dicom_date_time_seconds("1970"));
}

// --- enhanced files -----------------------------------------------------------------------------

// A file of two places at two times and with two echoes, in an order of its own.
TestSlice enhanced_series(bool has_values) {
  TestSlice slice = enhanced_slices();
  slice.num_frames = "8";
  slice.pixels.clear();
  DicomElements shared;
  shared.sequence(0x00209116, {DicomElements().text(0x00200037, "DS", "1\\0\\0\\0\\1\\0")});
  shared.sequence(0x00289110, {DicomElements().text(0x00280030, "DS", "2\\0.5")});
  std::vector<DicomElements> frames;
  const DicomElements e;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t time = i % 2, place = i / 2 % 2, echo = i / 4;
    DicomElements content;
    content.raw(
        0x00209157, "UL",
        e.long_word(1) + e.long_word(place + 1) + e.long_word(2 - time) + e.long_word(echo + 1));
    DicomElements frame;
    if (has_values)
      frame.sequence(0x00189114,
                     {DicomElements().raw(0x00189082, "FD", double_bytes(echo == 0 ? 5 : 9.5))});
    frame.sequence(0x00209111, {content});
    frame.sequence(0x00209113,
                   {DicomElements().text(0x00200032, "DS", fmt::format("0\\0\\{}", 3 * place))});
    frames.push_back(frame);
    for (int k = 0; k < 6; ++k) slice.pixels += e.word(static_cast<std::uint16_t>(i + 1));
  }
  std::vector<DicomElements> dimensions;
  for (const std::uint32_t pointer : {0x00209056U, 0x00209057U, 0x00209128U, 0x00189082U}) {
    dimensions.push_back(
        DicomElements().raw(0x00209165, "AT",
                            e.word(static_cast<std::uint16_t>(pointer >> 16)) +
                                e.word(static_cast<std::uint16_t>(pointer & 0xFFFF))));
  }
  slice.groups = DicomElements();
  slice.groups.sequence(0x00209222, dimensions);
  slice.groups.sequence(0x52009229, {shared});
  slice.groups.sequence(0x52009230, frames);
  return slice;
}

TEST(DicomSteps, DimensionsOfEnhancedFilesAreSteps) {
  const TestFolder folder;
  folder.write("a", dicom_slice(enhanced_series(false)));
  const Dataset dataset = read_dataset({folder.file("")});
  ASSERT_EQ(dataset.num_steps, 4);  // the first dimension slowest: times against the frames' order
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(3, 2, 2));
  const int expected[][2] = {{2, 4}, {6, 8}, {1, 3}, {5, 7}};
  for (int step = 0; step < 4; ++step) {
    EXPECT_THAT(first_samples(read_step(folder, step)),
                ElementsAre(expected[step][0], expected[step][1]));
  }
}

TEST(DicomSteps, EchoesOfEnhancedFilesAreVolumes) {
  const TestFolder folder;
  folder.write("a", dicom_slice(enhanced_series(true)));
  const Dataset dataset = read_dataset({folder.file("")});
  ASSERT_EQ(dataset.blocks.size(), 2U);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_THAT(first_samples(read_step(folder, 0, "4.2")), ElementsAre(6, 8));
  EXPECT_THAT(dataset.blocks[1].description, HasSubstr("echo 2 (9.5 ms)"));
}

}  // namespace dicom_steps_test
}  // namespace ovoid::io
