// SPDX-License-Identifier: Apache-2.0
//
// Samples -> cosine coefficients, axis after axis -> those outside of the ball are weakened ->
// back. A cosine transform of n samples is a Fourier transform of the same n, even ones first, odd
// ones behind in reverse order [Makhoul 1980].
#include "model/lattice/band_limit.h"

#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <span>
#include <unsupported/Eigen/FFT>

#include "data/parallel.h"
#include "model/lattice/lines.h"

namespace ovoid::model {
namespace {

using Complex = std::complex<double>;

// One thread's transforms of lines of one length.
class CosineTransform {
 public:
  explicit CosineTransform(std::size_t n) : in_(n), out_(n), turn_(n) {
    for (std::size_t k = 0; k < n; ++k)
      turn_[k] = std::polar(
          1.0, -std::numbers::pi * static_cast<double>(k) / (2 * static_cast<double>(n)));
  }

  void forward(std::span<const float> from, std::span<float> to) {
    const std::size_t n = in_.size();
    for (std::size_t i = 0; i < n; ++i) in_[place_of(i)] = static_cast<double>(from[i]);
    fft_.fwd(out_, in_);
    for (std::size_t k = 0; k < n; ++k) to[k] = static_cast<float>(2 * (turn_[k] * out_[k]).real());
  }

  void inverse(std::span<const float> from, std::span<float> to) {
    const std::size_t n = in_.size();
    for (std::size_t k = 0; k < n; ++k) {
      const double other = k == 0 ? 0.0 : static_cast<double>(from[n - k]);
      in_[k] = 0.5 * std::conj(turn_[k]) * Complex(static_cast<double>(from[k]), -other);
    }
    fft_.inv(out_, in_);
    for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<float>(out_[place_of(i)].real());
  }

 private:
  std::size_t place_of(std::size_t i) const { return i % 2 == 0 ? i / 2 : in_.size() - 1 - i / 2; }

  Eigen::FFT<double> fft_;
  std::vector<Complex> in_, out_, turn_;
};

CosineTransform& transform_of_length(std::size_t n) {
  thread_local std::size_t length = 0;
  thread_local std::unique_ptr<CosineTransform> transform;
  if (!transform || length != n) {
    transform = std::make_unique<CosineTransform>(n);
    length = n;
  }
  return *transform;
}

// What is left of a frequency.
double response(double frequency, double radius) {
  const double share = frequency / radius;
  if (share <= kBandShoulder) return 1;
  if (share >= 1) return 0;
  return 0.5 * (1 + std::cos(std::numbers::pi * (share - kBandShoulder) / (1 - kBandShoulder)));
}

// `coefficients`: [n3][n2][n1][n0].
using Index4 = std::array<std::int64_t, 4>;

void weaken(std::vector<float>& coefficients, const Index4& n, const BandLimit& limit) {
  const auto frequency = [&](std::int64_t k, std::size_t a) {
    return static_cast<double>(k) / (2 * static_cast<double>(n[a]));
  };
  data::parallel_ranges({n[1] * n[2] * n[3], 16, limit.threads, limit.stop}, [&](std::int64_t begin,
                                                                                 std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      const double y = frequency(row % n[1], 1);
      const double z = frequency(row / n[1] % n[2], 2);
      const double t = frequency(row / (n[1] * n[2]), 3);
      const double others = y * y + z * z + t * t;
      for (std::int64_t k = 0; k < n[0]; ++k) {
        const double x = frequency(k, 0);
        coefficients[static_cast<std::size_t>(row * n[0] + k)] *=
            static_cast<float>(response(std::sqrt(x * x + others), limit.radius));
      }
    }
  });
}

}  // namespace

void limit_band(std::vector<float>& samples, const Index3& dims, const BandLimit& limit) {
  limit_band_in_time(samples, dims, 1, limit);
}

void limit_band_in_time(std::vector<float>& samples, const Index3& dims, std::int64_t num_steps,
                        const BandLimit& limit) {
  const Index4 n{dims[0], dims[1], dims[2], num_steps};
  const auto along_every_axis = [&](auto member) {
    for (std::size_t a = 0; a < 4; ++a) {
      if (n[a] == 1) continue;
      // The axis among all faster and all slower ones together.
      Index3 shape{1, n[a], 1};
      for (std::size_t b = 0; b < a; ++b) shape[0] *= n[b];
      for (std::size_t b = a + 1; b < 4; ++b) shape[2] *= n[b];
      samples = transform_lines(samples, shape, n[a],
                                [&](std::span<const float> from, std::span<float> to) {
                                  (transform_of_length(from.size()).*member)(from, to);
                                },
                                {1, limit.threads, limit.stop});
    }
  };
  along_every_axis(&CosineTransform::forward);
  weaken(samples, n, limit);
  along_every_axis(&CosineTransform::inverse);
}

}  // namespace ovoid::model
