// SPDX-License-Identifier: Apache-2.0
// LibLZF's compressed data, which h5py's filter "lzf" writes into HDF5 files [LZF]: runs of bytes
// as they are, and copies of bytes that were written shortly before.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace ovoid::io {

// A copy stands for at most 264 bytes and takes three.
inline constexpr std::size_t kMaxLzfRatio = 264 / 3;

// How many bytes the data stand for; nothing if they end within a run or a copy, or copy what was
// not written yet.
std::optional<std::size_t> lzf_size(std::span<const std::byte> packed) noexcept;

// Unpacks data of which lzf_size() has told the size, which `out` has.
void unpack_lzf(std::span<const std::byte> packed, std::span<std::byte> out) noexcept;

}  // namespace ovoid::io
