// SPDX-License-Identifier: Apache-2.0
// A glTF 2 file taken apart: its text, and the numbers that the text speaks of, wherever they are.
// Nothing that the text says of sizes and places is believed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/json_file.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Elements of numbers, all of which are there.
class GltfNumbers {
 public:
  std::int64_t count() const noexcept { return count_; }
  int components() const noexcept { return components_; }
  // One unsigned whole number each.
  bool are_indices() const noexcept {
    return components_ == 1 && (type_ == kUInt8 || type_ == kUInt16 || type_ == kUInt32);
  }
  double at(std::int64_t element, int component) const;  // whole numbers that are shares as these
  std::uint32_t index_at(std::int64_t element) const;    // are_indices()

 private:
  friend class GltfFile;
  enum Type { kInt8 = 5120, kUInt8, kInt16, kUInt16, kUInt32 = 5125, kFloat };
  static std::size_t size_of(Type type) noexcept;

  const std::byte* first_ = nullptr;
  std::size_t stride_ = 0;
  std::int64_t count_ = 0;
  int components_ = 1;
  Type type_ = kFloat;
  bool is_normalized_ = false;
};

class GltfFile {
 public:
  // Reads all of it. Throws Error: kFileFormat, naming what is wrong and where in the text;
  // kUnsupported for other versions than 2; what `open` throws; kCancelled.
  GltfFile(const ByteSource& source, const ReadOptions& options, const Opener& open);

  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  const JsonValue& text() const noexcept { return text_; }
  std::size_t count(const char* list) const;
  JsonValue element(const char* list, std::size_t i) const;  // an object
  // What a value numbers in a list of the text.
  std::size_t index(const JsonValue& value, const char* list) const;
  // Of the accessor that a value numbers. Throws Error(kUnsupported) for sparse and empty ones.
  GltfNumbers numbers(const JsonValue& value) const;

 private:
  struct View {
    const std::byte* first = nullptr;
    std::size_t bytes = 0, stride = 0;
  };
  View view(std::size_t i) const;
  void read_buffer(const JsonValue& buffer, const ByteSource& source, const ReadOptions& options,
                   const Opener& open);

  Json json_;
  std::int64_t binary_offset_ = 0, binary_bytes_ = 0;  // of the numbers behind the text
  JsonValue text_;
  std::vector<std::vector<std::byte>> buffers_;
};

// The files of its numbers, beside it, as far as they are there.
std::vector<std::string> gltf_companions(const ByteSource& source);

}  // namespace ovoid::io
