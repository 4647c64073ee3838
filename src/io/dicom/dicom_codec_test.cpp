// SPDX-License-Identifier: Apache-2.0
// Compressed pixel data against the samples they were made from: RLE by hand, the others by GDCM's
// encoders. What would make these fail: bytes exchanged, a stream believed against its file.
#include "io/dicom/dicom_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/core/test_folder.h"
#include "io/dicom/test_dicom.h"
#include "io/dicom/test_dicom_streams.h"
#include "io/foreign/gdcm_codec.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"
#include "support/where.h"

namespace ovoid::io {
namespace dicom_codec_test {

using testing::HasSubstr;

TestSlice compressed_slice(const std::string& uid, const std::vector<std::string>& fragments) {
  TestSlice slice;
  slice.uid = uid;
  slice.rows = 17;
  slice.columns = 23;
  slice.is_encapsulated = true;
  slice.pixels = encapsulated(fragments);
  return slice;
}

// In this process.
Dataset read_slice_of(const TestSlice& slice) {
  use_gdcm();
  const std::string file = dicom_slice(slice);
  return read_source(*open_memory("a.dcm", std::as_bytes(std::span(file))), {});
}

std::string samples_of(const Dataset& dataset) {
  const auto view = dataset.arrays.at(0).bytes.view;
  return {reinterpret_cast<const char*>(view.data()), view.size()};
}

TEST(DicomCodec, RleFramesComeOutAsTheyWentIn) {
  const std::string samples = pixels_of(17 * 23, 4095);
  const std::string frame = rle_frame(samples);
  EXPECT_EQ(samples_of(read_slice_of(compressed_slice(kRleUid, {frame}))), samples);
  // One frame in three pieces.
  TestSlice slice =
      compressed_slice(kRleUid, {frame.substr(0, 40), frame.substr(40, 100), frame.substr(140)});
  EXPECT_EQ(samples_of(read_slice_of(slice)), samples);
  // Two frames of two pieces: the table of offsets tells which are whose.
  const DicomElements e;
  const std::string table =
      e.long_word(0) + e.long_word(static_cast<std::uint32_t>(16 + (frame.size() + 1) / 2 * 2));
  slice.num_frames = "2";
  slice.pixels = encapsulated(
      {frame.substr(0, 40), frame.substr(40), frame.substr(0, 2), frame.substr(2)}, table);
  EXPECT_EQ(samples_of(read_slice_of(slice)), samples + samples);
  slice.pixels = encapsulated({frame.substr(0, 40), frame.substr(40), frame});
  EXPECT_THAT(error_of([&] { read_slice_of(slice); }),
              HasSubstr("cannot tell which belong together"));
}

TEST(DicomCodec, DamagedRleIsNamed) {
  OVOID_NOT_UNDER_TSAN();
  const std::string frame = rle_frame(pixels_of(17 * 23, 4095));
  const auto error = [](const std::string& stream) {
    return error_of([&] { read_slice_of(compressed_slice(kRleUid, {stream})); });
  };
  EXPECT_THAT(error(frame.substr(0, frame.size() - 20)), HasSubstr("segment"));
  EXPECT_THAT(error(frame.substr(0, 60)), HasSubstr("is cut short"));
  std::string wrong = frame;
  wrong[0] = 3;
  EXPECT_THAT(error(wrong), HasSubstr("has 3 segments: expected 2 for samples of 16 bits"));
  wrong = frame;
  wrong[6] = 1;
  EXPECT_THAT(error(wrong), HasSubstr("segment 0 lies outside of it"));
}

#ifdef OVOID_IO_GDCM

TEST(DicomCodec, LosslessFramesComeOutAsTheyWentIn) {
  const std::string samples = pixels_of(17 * 23, 4095);
  for (const auto& [uid, frame] :
       {std::pair(kJpegUid, jpeg_lossless(samples)), std::pair(kJpegLsUid, jpeg_ls(samples)),
        std::pair(kJpeg2000Uid, jpeg2000(samples))}) {
    SCOPED_TRACE(uid);
    EXPECT_EQ(samples_of(read_slice_of(compressed_slice(uid, {frame}))), samples);
    // In two pieces, and with an end that is not there.
    const TestSlice pieces = compressed_slice(uid, {frame.substr(0, 50), frame.substr(50)});
    EXPECT_EQ(samples_of(read_slice_of(pieces)), samples);
    TestSlice larger = compressed_slice(uid, {frame});
    larger.rows = 18;
    EXPECT_THAT(error_of([&] { read_slice_of(larger); }),
                HasSubstr("says 23x17, 1 components: the file says 23x18, 1"));
  }
}

// As the library reads them: the codecs are in the reader's process.
TEST(DicomCodec, FramesAreDecodedElsewhere) {
  const TestFolder folder;
  const std::string samples = pixels_of(17 * 23, 4095);
  const std::string path =
      folder.write("a.dcm", dicom_slice(compressed_slice(kJpegLsUid, {jpeg_ls(samples)})));
  EXPECT_EQ(samples_of(read_dataset({path})), samples);
}

TEST(DicomCodec, SixteenBitsAndSigns) {
  std::string samples;
  const DicomElements e;
  for (int i = 0; i < 17 * 23; ++i) samples += e.word(static_cast<std::uint16_t>(i * 977 - 30000));
  TestSlice slice = compressed_slice(kJpeg2000Uid, {jpeg2000(samples, true)});
  slice.stored = 16;
  slice.high_bit = 15;
  slice.is_signed = 1;
  const Dataset dataset = read_slice_of(slice);
  EXPECT_EQ(dataset.arrays.at(0).type, ScalarType::kInt16);
  EXPECT_EQ(samples_of(dataset), samples);
  slice = compressed_slice(kJpegUid, {jpeg_lossless(samples, 16, 16)});
  slice.stored = 16;
  slice.high_bit = 15;
  EXPECT_EQ(samples_of(read_slice_of(slice)), samples);
}

// Other encoders than GDCM's write the precision that is stored, not the width of the word.
TEST(DicomCodec, LosslessJpegOfFewerBits) {
  testing::internal::CaptureStderr();
  const std::string samples = pixels_of(17 * 23, 4095);
  EXPECT_EQ(samples_of(read_slice_of(compressed_slice(kJpegUid, {jpeg_lossless(samples, 12, 12)}))),
            samples);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// Lossy, so not the same: but near, and of the file's words whether the stream has 8 or 12 bits.
TEST(DicomCodec, BaselineAndExtendedJpeg) {
  testing::internal::CaptureStderr();
  for (const std::uint16_t bits : {std::uint16_t{8}, std::uint16_t{12}}) {
    SCOPED_TRACE(bits);
    const int most = (1 << bits) - 1;
    std::string samples;
    const DicomElements e;
    for (int i = 0; i < 17 * 23; ++i) {
      const auto value = static_cast<std::uint16_t>(most * (i % 23) / 22);
      samples += bits == 8 ? std::string(1, static_cast<char>(value)) : e.word(value);
    }
    gdcm::JPEGCodec codec;
    codec.SetLossless(false);
    codec.SetQuality(100);
    const std::string frame = encoded(codec, samples, bits, bits);
    TestSlice slice =
        compressed_slice(bits == 8 ? "1.2.840.10008.1.2.4.50" : "1.2.840.10008.1.2.4.51", {frame});
    if (bits == 8) slice.allocated = 8;
    slice.stored = bits;
    slice.high_bit = static_cast<std::uint16_t>(bits - 1);
    const std::string decoded = samples_of(read_slice_of(slice));
    ASSERT_EQ(decoded.size(), samples.size());
    const auto value = [&](const std::string& text, std::size_t i) {
      const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
      return bits == 8 ? byte(i) : byte(2 * i) + 256 * byte(2 * i + 1);
    };
    for (std::size_t i = 0; i < 17 * 23; ++i)
      EXPECT_NEAR(value(decoded, i), value(samples, i), most / 50) << i;
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// Fails if a damaged stream makes the codecs crash, or gives other than all samples or an error;
// what it says of itself is checked first. Nothing at all is never a picture. What is printed can
// be held to nothing for JPEG-LS alone: libjpeg and OpenJPEG warn whatever GDCM is told.
TEST(DicomCodec, DamagedStreamsAreErrorsOrSamples) {
  OVOID_NOT_UNDER_TSAN();
  const std::string samples = pixels_of(17 * 23, 4095);
  for (const auto& [uid, frame] :
       {std::pair(kJpegUid, jpeg_lossless(samples)), std::pair(kJpegLsUid, jpeg_ls(samples)),
        std::pair(kJpeg2000Uid, jpeg2000(samples))}) {
    SCOPED_TRACE(uid);
    testing::internal::CaptureStderr();
    for (std::size_t size = 0; size < frame.size(); size += 3) {
      const TestSlice cut = compressed_slice(uid, {frame.substr(0, size)});
      std::size_t num_bytes = 0;
      const std::string error =
          error_of([&] { num_bytes = samples_of(read_slice_of(cut)).size(); });
      EXPECT_EQ(num_bytes, error.empty() ? samples.size() : 0U) << "cut to " << size;
      EXPECT_TRUE(size > 0 || !error.empty());
    }
    const std::string printed = testing::internal::GetCapturedStderr();
    if (std::string(uid) == kJpegLsUid) {
      EXPECT_EQ(printed, "");
    }
  }
}

#endif

}  // namespace dicom_codec_test
}  // namespace ovoid::io
