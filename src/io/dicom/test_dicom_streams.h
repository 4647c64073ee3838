// SPDX-License-Identifier: Apache-2.0
// For tests and fuzzing: compressed frames of 23 x 17 samples, by GDCM's encoders where it is
// there.
#pragma once

#include <cstdint>
#include <string>

#include "io/dicom/test_dicom.h"

#ifdef OVOID_IO_GDCM
#include <gdcmDataElement.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#endif

namespace ovoid::io {

inline constexpr const char* kRleUid = "1.2.840.10008.1.2.5";
inline constexpr const char* kJpegUid = "1.2.840.10008.1.2.4.70";
inline constexpr const char* kJpegLsUid = "1.2.840.10008.1.2.4.80";
inline constexpr const char* kJpeg2000Uid = "1.2.840.10008.1.2.4.90";

// `count` samples of 16 bits, from 0 to `most`.
inline std::string pixels_of(int count, int most) {
  std::string result;
  const DicomElements e;
  for (int i = 0; i < count; ++i)
    result += e.word(static_cast<std::uint16_t>((i * i / 3 + (i / 7) * 40) % (most + 1)));
  return result;
}

#ifdef OVOID_IO_GDCM

template <typename GdcmCodec>
std::string encoded(GdcmCodec& codec, const std::string& samples, unsigned short allocated,
                    unsigned short stored, bool is_signed = false) {
  const unsigned dims[3] = {23, 17, 1};
  codec.SetDimensions(dims);
  codec.SetNumberOfDimensions(2);
  codec.SetPlanarConfiguration(0);
  codec.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  codec.SetPixelFormat(gdcm::PixelFormat(
      1, allocated, stored, static_cast<unsigned short>(stored - 1), is_signed ? 1 : 0));
  gdcm::DataElement in(gdcm::Tag(0x7FE0, 0x0010)), out;
  in.SetByteValue(samples.data(), gdcm::VL(static_cast<std::uint32_t>(samples.size())));
  if (!codec.Code(in, out)) return {};
  const auto* fragments = out.GetSequenceOfFragments();
  if (fragments == nullptr || fragments->GetNumberOfFragments() != 1) return {};
  const auto* bytes = fragments->GetFragment(0).GetByteValue();
  return {bytes->GetPointer(), bytes->GetLength()};
}

inline std::string jpeg_lossless(const std::string& samples, unsigned short allocated = 16,
                                 unsigned short stored = 12) {
  gdcm::JPEGCodec codec;
  codec.SetLossless(true);
  return encoded(codec, samples, allocated, stored);
}

inline std::string jpeg_ls(const std::string& samples) {
  gdcm::JPEGLSCodec codec;
  codec.SetLossless(true);
  return encoded(codec, samples, 16, 12);
}

inline std::string jpeg2000(const std::string& samples, bool is_signed = false) {
  gdcm::JPEG2000Codec codec;
  codec.SetReversible(true);
  return encoded(codec, samples, 16, is_signed ? 16 : 12, is_signed);
}

#endif

}  // namespace ovoid::io
