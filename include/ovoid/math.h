// SPDX-License-Identifier: Apache-2.0
// Small linear algebra used by the public interface: aliases of Eigen's types, so that callers can
// use Eigen directly. All of them have the alignment of a double, whatever the compiler may assume
// of the processor (-mavx, for instance): Eigen would align its own affine transform to the widest
// register, and a library and a program built with different flags would then disagree on the
// layout of every structure with one in it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

using Vec3 = Eigen::Vector3d;  // double precision: all transforms are double
using Mat3 = Eigen::Matrix3d;
// Named to_from: `world_from_index * index = world`. Eigen::Affine3d converts to it, and back.
using Affine3 = Eigen::Transform<double, 3, Eigen::Affine, Eigen::DontAlign>;
using Bounds3 = Eigen::AlignedBox3d;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));
static_assert(sizeof(Mat3) == 9 * sizeof(double) && alignof(Mat3) == alignof(double));
static_assert(sizeof(Affine3) == 16 * sizeof(double) && alignof(Affine3) == alignof(double));
static_assert(sizeof(Bounds3) == 6 * sizeof(double) && alignof(Bounds3) == alignof(double));

}  // namespace ovoid
