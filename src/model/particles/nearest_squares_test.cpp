// SPDX-License-Identifier: Apache-2.0
#include "model/particles/nearest_squares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "model/lattice/noise.h"

namespace ovoid::model {
namespace nearest_squares_test {

using Place = std::array<float, 3>;

std::vector<Place> places_in(float edge, int count, bool are_whole, std::uint64_t seed) {
  Random random(seed);
  std::vector<Place> places;
  for (int i = 0; i < count; ++i) {
    Place at{};
    for (float& x : at) {
      x = edge * static_cast<float>(random.uniform(0, 1));
      if (are_whole) x = std::floor(x);
    }
    places.push_back(at);
  }
  return places;
}

void append(CandidateBatch& batch, std::span<const Place> places) {
  CandidateChunk chunk{};
  chunk.count = static_cast<std::int32_t>(places.size());
  Place low = places[0], high = places[0];
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      chunk.places[a][i] = 2 * (places[i][a] - 1);  // offset 1, unit 1/2
      low[a] = std::min(low[a], places[i][a]);
      high[a] = std::max(high[a], places[i][a]);
    }
  }
  batch.append(chunk, {1, 1, 1}, 0.5F, low, high);
}

float square(const Place& a, const Place& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
         (a[2] - b[2]) * (a[2] - b[2]);
}

// Against sorting, of every instruction set; whole numbers have many equal distances. Some batches
// come one after the other, so that what is kept between them counts.
TEST(NearestSquares, AreThoseOfSorting) {
  for (const std::string& name : simd::SimdTarget::usable()) {
    const simd::SimdTarget target(name);
    for (const bool are_whole : {false, true}) {
      for (const std::size_t k : {1, 5, 32, 150}) {
        for (const int count : {1, 7, 149, 150, 900, 3000}) {
          const std::vector<Place> places = places_in(are_whole ? 6.0F : 1.0F, count, are_whole, 3);
          const auto batch = std::make_unique<CandidateBatch>();
          NearestSquares nearest(k);
          nearest.start();
          constexpr std::size_t kSites = 4;
          for (std::size_t i = 0; i < kSites; ++i) {
            const Place& at = places[i * 7 % places.size()];
            nearest.add_site(at[0], at[1], at[2]);
          }
          std::size_t chunk_size = 1;
          for (std::size_t i = 0; i < places.size(); i += chunk_size) {
            chunk_size = std::min(1 + i % CandidateChunk::kRoom, places.size() - i);
            if (batch->num_chunks() == CandidateBatch::kMostChunks) {
              nearest.add(target, *batch, NearestSquares::Wanted::kMoreToCome);
              batch->clear();
            }
            append(*batch, std::span(places).subspan(i, chunk_size));
          }
          nearest.add(target, *batch, NearestSquares::Wanted::kLast);
          for (std::size_t i = 0; i < kSites; ++i) {
            std::vector<float> squares;
            for (const Place& at : places)
              squares.push_back(square(at, places[i * 7 % places.size()]));
            std::sort(squares.begin(), squares.end());
            if (squares.size() < k) {
              EXPECT_EQ(nearest.bound(i), NearestSquares::kNoBound);
            } else {
              EXPECT_NEAR(nearest.bound(i), squares[k - 1], 1e-5F * (squares[k - 1] + 1e-2F))
                  << name << ", k " << k << " of " << count;
            }
          }
        }
      }
    }
  }
}

// An estimate bounds the k-th from above, and leaves nothing behind.
TEST(NearestSquares, EstimatesAreBounds) {
  const std::vector<Place> places = places_in(1, 96, false, 5);
  const auto batch = std::make_unique<CandidateBatch>();
  for (std::size_t i = 0; i < places.size(); i += 32)
    append(*batch, std::span(places).subspan(i, 32));
  NearestSquares nearest(32);
  nearest.start();
  nearest.add_site(0.5F, 0.5F, 0.5F);
  EXPECT_EQ(nearest.add(simd::SimdTarget(), *batch, NearestSquares::Wanted::kEstimate), 96);
  const float estimate = nearest.bound(0);
  nearest.add(simd::SimdTarget(), *batch, NearestSquares::Wanted::kLast);
  EXPECT_LE(nearest.bound(0), estimate);
  EXPECT_LT(estimate, 1.5F * nearest.bound(0));
}

}  // namespace nearest_squares_test
}  // namespace ovoid::model
