// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/gdcm_codec.h"

#ifdef OVOID_IO_GDCM
#include <gdcmDataElement.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <vector>

#include "io/dicom/dicom_codec.h"

namespace ovoid::io {
namespace {

// What GDCM's codecs ask of their input beyond the standard: a stream that goes on behind its end
// would keep the JPEG codec waiting for more, and the JPEG 2000 codec looks for the last EOC.
std::vector<char> closed_stream(DicomCodec codec, std::span<const std::byte> stream) {
  const auto* const chars = reinterpret_cast<const char*>(stream.data());
  std::vector<char> result(chars, chars + stream.size());
  constexpr std::array<char, 2> kEnd = {'\xff', '\xd9'};
  if (codec == DicomCodec::kJpeg2000) {
    while (result.size() > 2 && result.back() != kEnd[1]) result.pop_back();
    if (result.size() > 2 && result[result.size() - 2] == kEnd[0]) return result;
  }
  result.insert(result.end(), kEnd.begin(), kEnd.end());
  return result;
}

template <typename GdcmCodec>
bool run_gdcm(GdcmCodec& codec, const DicomFrameShape& shape, const DicomStreamHeader& header,
              const gdcm::DataElement& in, gdcm::DataElement& out) {
  const unsigned dims[3] = {static_cast<unsigned>(shape.columns), static_cast<unsigned>(shape.rows),
                            1};
  codec.SetDimensions(dims);
  codec.SetNumberOfDimensions(2);
  codec.SetPlanarConfiguration(0);
  codec.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  const auto bits = static_cast<unsigned short>(header.precision);
  // By the width GDCM chooses among its builds of the JPEG codec: that for 16 bits is lossless
  // only.
  const unsigned short width = bits <= 8 ? 8 : header.is_lossy ? 12 : 16;
  codec.SetPixelFormat(gdcm::PixelFormat(1, width, bits, static_cast<unsigned short>(bits - 1), 0));
  return codec.Decode(in, out);
}

bool decode_with_gdcm(DicomCodec which, const DicomFrameShape& shape,
                      const DicomStreamHeader& header, const gdcm::DataElement& in,
                      gdcm::DataElement& out) {
  if (which == DicomCodec::kJpeg) {
    gdcm::JPEGCodec codec;
    return run_gdcm(codec, shape, header, in, out);
  }
  if (which == DicomCodec::kJpegLs) {
    gdcm::JPEGLSCodec codec;
    return run_gdcm(codec, shape, header, in, out);
  }
  gdcm::JPEG2000Codec codec;
  return run_gdcm(codec, shape, header, in, out);
}

std::vector<char> decode(DicomCodec codec, std::span<const std::byte> stream,
                         const DicomFrameShape& shape, const DicomStreamHeader& header) {
  const std::vector<char> closed = closed_stream(codec, stream);
  gdcm::Fragment fragment;
  fragment.SetByteValue(closed.data(), gdcm::VL(static_cast<std::uint32_t>(closed.size())));
  gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
  fragments->AddFragment(fragment);
  gdcm::DataElement in(gdcm::Tag(0x7FE0, 0x0010)), decoded;
  in.SetValue(*fragments);
  try {
    if (!decode_with_gdcm(codec, shape, header, in, decoded)) return {};
  } catch (const std::exception&) {
    return {};
  }
  const gdcm::ByteValue* const bytes = decoded.GetByteValue();
  if (bytes == nullptr) return {};
  return {bytes->GetPointer(), bytes->GetPointer() + bytes->GetLength()};
}

}  // namespace

void use_gdcm() noexcept {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  set_foreign_dicom_decoder(&decode);
}

}  // namespace ovoid::io

#else

void ovoid::io::use_gdcm() noexcept {}

#endif
