// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

// A file in VTK's XML form while it is put together: its elements as text, and arrays, whose bytes
// are appended to it raw, in native byte order and with sizes of 64 bits. Without VTK.
class XmlArrayFile {
 public:
  enum class Packing { kPlain, kZlib };

  // `type`: of the data set, "ImageData". The root element is opened, and closed by write().
  XmlArrayFile(const std::string& type, Packing packing);

  // Elements, indented and with their line ends.
  void text(const std::string& elements) { header_ += elements; }
  // The element of an array, and its bytes, which stay the caller's until write() is done.
  void array(const std::string& name, ScalarType type, int num_components,
             std::span<const std::byte> bytes, const std::string& unit = {});
  void array(const DataArray& from) {
    array(from.name, from.type, from.num_components, from.bytes.view, from.unit);
  }

  // Packed arrays are packed while they are written, a block at a time; where each begins is filled
  // in at the end, so that the target must be a file or a device that can be gone back in. Throws
  // Error(kFileWrite, kCancelled).
  void write(const std::string& path, const std::stop_token& stop = {}) const;

 private:
  struct Piece {
    std::span<const std::byte> bytes;
    std::size_t offset_at;  // in the header: the field for where the piece begins
  };

  void write_packed(const std::string& path, const std::stop_token& stop) const;

  Packing packing_;
  std::string header_;
  std::vector<Piece> pieces_;
  std::uint64_t num_appended_ = 0;  // bytes, of plain arrays
};

// As it may stand in an element or between quotes: characters that mean something replaced by
// references, and what no XML file may hold by a blank or a question mark.
std::string xml_text(const std::string& text);

}  // namespace ovoid::io
