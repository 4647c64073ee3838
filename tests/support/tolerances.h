// SPDX-License-Identifier: Apache-2.0
// Every tolerance of the tests that need more than one part: name, metric, bound, and where the
// bound comes from.
#pragma once

#include <limits>

namespace ovoid::test {

// ---- Agreement of a back end with the reference
// ---------------------------------------------------------------------

// PSNR over pixels covered in either picture, peak 1, premultiplied RGBA. The tier of the design
// for pictures without post-convolution: float sums of some hundred terms err by 1e-6 of the range,
// a transfer function with a peak of 2 % of the range makes 50 times that of it, compositing adds
// up to some dozen such samples of one sign: 6e-4, -64 dB.
inline constexpr double kAgreementPsnrDb = 60;

// Greatest difference of a channel in 8-bit steps, premultiplied. One step is what rounding does by
// itself at a tie, the other what the sums above can do.
inline constexpr int kAgreement8BitDifference = 2;

// Of a thousand covered pixels of refined pieces: whether a piece is cut into as many steps or
// twice as many, and whether it has one end or two where the field ends, is decided by the rounding
// of its ends. Any one pixel may be such; those of steep looks then differ by up to some 30 steps
// of 8 bits, and the other pixels are held to both bounds above.
inline constexpr double kRefinedBeyondPerMille = 2.5;

// Share of the pixels whose depth may be another sheet's: where the opacity reaches a half within
// the rounding of a sample, either sheet is right.
inline constexpr double kAgreementOtherDepths = 0.005;

// The same of front depths. Where a look begins gently, many small steps lead to 1/255; which of
// them reaches it, and whether a piece there has one step or two, is decided by rounding more
// often.
inline constexpr double kAgreementOtherFronts = 0.01;

// Where a field ends, a sample at the end itself exists or not by its rounding, and with it its
// whole opacity, here at most 0.7 * 0.15 * 255 = 27 steps of 8 bits. Of a field that is all end
// (one sample's ball of 0.09 spacings) a few hundred pixels are seen; one in them is 10 dB less.
inline constexpr double kAllEndPsnrDb = 50;
inline constexpr int kAllEnd8BitDifference = 27;

// Means of a profile with a kink at its end, by eight nodes per slab: each errs by up to an eighth
// of what a kernel has at its end. Where the field itself ends, at a fifth of the weights, that
// decides whether single samples of some tens of 8-bit steps are there.
inline constexpr double kKinkedMeanPsnrDb = 45;
inline constexpr int kKinkedMean8BitDifference = 64;

// Sheets of 16 bits: the tier of the design. Looks in which one sample can err by more than half an
// 8-bit step keep floats; compositing adds up to some eight such samples of one sign.
inline constexpr double kHalfSheetsPsnrDb = 55;
inline constexpr int kHalfSheets8BitDifference = 4;

// Pictures with post-convolution against those without: the design's tier.
inline constexpr double kLevelsPsnrDb = 50;

// Pictures of a lattice's levels, against the mean of 4 x 4 finer rays, may be less near than those
// of the widened kernels by as much: means of samples blur by a quarter of a spacing squared more,
// which where pixels are just two spacings wide costs fine patterns 4 dB by B-splines and 5.4 by
// Gaussians, and scans 0.7.
inline constexpr double kLevelsLoseDb = 6;

// ---- Closed forms against the reference
// -----------------------------------------------------------------------------

// Relative to the greatest magnitude of what is compared: some hundred additions in double (100 eps
// = 2e-14), and closed forms with one erf or exp each; 50 times that for positions off the origin
// by 1e2 spacings, rounded before use.
inline constexpr double kDoubleRelative = 1e-12;

// What a float32 picture can show of a number in double: half a unit in the last place is 6e-8 of
// it.
inline constexpr double kFloatRelative = 1.2e-7;

// Gradient against differences of fourth order with step 1e-3 spacings. For sigma = 1/2 the fifth
// derivative of a unit kernel is below 32 * 60: 1e-12 / 30 * 2e3 = 7e-11 of the values' range;
// rounding adds eps / 1e-3 = 2e-13 of the values themselves. 30 times that, for quotients and for
// several kernels adding up.
inline constexpr double kGradientRelative = 2e-9;

// Greatest share of a Gaussian line integral beyond the support box of cutoff 4: erfc(4 / sqrt 2)
// = 6.3e-5 on each of three axes.
inline constexpr double kCutOffShare = 2e-4;

// Greatest error of line integrals made of slabs' sections, of the peak: half a per cent, since
// each section has the mean and the variance of its part of an ellipsoid, but not its skew.
inline constexpr double kSectionsShare = 5e-3;

// Half-amplitude of the sum of Gaussians with sigma half their spacing, one axis, of its mean: 2
// exp(-pi^2 / 2).
inline constexpr double kAxisRipple = 0.0144;

// A printed number of n digits after the point stands for +- half of the last one; names say which.
inline constexpr double kFourDigits = 0.5e-4 * (1 + 1e-9);
inline constexpr double kFiveDigits = 0.5e-5 * (1 + 1e-9);

}  // namespace ovoid::test
