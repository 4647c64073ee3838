// SPDX-License-Identifier: Apache-2.0
// The k nearest of a few sites at once, in floats (SIMD). What lies around is handed over in
// batches of chunks; each batch brings the sites' bounds closer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "simd/simd_target.h"

namespace ovoid::model {

// Candidates beside each other, as offsets from a place of theirs.
struct CandidateChunk {
  static constexpr std::size_t kRoom = 32;
  float places[3][kRoom];
  std::int32_t count;
};

// Candidates as columns, in chunks with boxes.
class CandidateBatch {
 public:
  static constexpr std::size_t kChunkRoom = CandidateChunk::kRoom;
  static constexpr std::size_t kMostChunks = 64;

  std::size_t num_chunks() const noexcept { return num_chunks_; }
  void clear() noexcept { num_chunks_ = 0; }

  // Appends a chunk, where there is room for one: its candidates lie at offset + unit * place, and
  // within [low, high]. No number exceeds kFarAway.
  void append(const CandidateChunk& chunk, const std::array<float, 3>& offset, float unit,
              const std::array<float, 3>& low, const std::array<float, 3>& high) {
    const std::size_t number = num_chunks_++;
    sizes[number] = chunk.count;
    for (std::size_t a = 0; a < 3; ++a) {
      float* const column = places[a] + number * kChunkRoom;
      for (std::size_t i = 0; i < kChunkRoom; ++i)
        column[i] = offset[a] + unit * chunk.places[a][i];
      lows[a][number] = low[a];
      highs[a][number] = high[a];
    }
  }

  static constexpr float kFarAway = 1e15F;
  alignas(64) float lows[3][kMostChunks];
  alignas(64) float highs[3][kMostChunks];
  alignas(64) float places[3][kMostChunks * kChunkRoom];
  std::int32_t sizes[kMostChunks];

 private:
  std::size_t num_chunks_ = 0;
};

// Sites and the squares of their distances to the nearest candidates so far.
class NearestSquares {
 public:
  static constexpr float kNoBound = 1e32F;

  explicit NearestSquares(std::size_t k) : k_(k) {}

  void start() { num_sites_ = 0; }
  void add_site(float x, float y, float z);

  std::size_t num_sites() const noexcept { return num_sites_; }
  // The square of the k-th nearest's distance, kNoBound while there are fewer than k.
  float bound(std::size_t site) const noexcept { return bounds_[site]; }
  float widest_bound() const noexcept;

  // What a batch is for.
  enum class Wanted : std::uint8_t {
    kEstimate,    // bounds, for the choice of the candidates; these come again
    kMoreToCome,  // the nearest so far
    kLast,
  };

  // After the last batch bound() is that of the k-th nearest of all. Returns how many pairs were
  // compared. Cost: some ten operations of a vector's width for each.
  std::int64_t add(const simd::SimdTarget& target, const CandidateBatch& batch, Wanted wanted);

  // For add().
  struct Site {
    float at[3];
    float bound;
    std::size_t count;  // of `kept`
    float* kept;        // room for k
  };

 private:
  std::size_t k_;
  std::size_t num_sites_ = 0;
  std::vector<std::array<float, 3>> places_;
  std::vector<float> bounds_;
  std::vector<std::size_t> counts_;
  std::vector<float> kept_;     // [site][k]
  std::vector<float> squares_;  // of the site in hand
};

}  // namespace ovoid::model
