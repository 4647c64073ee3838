// SPDX-License-Identifier: Apache-2.0
// Small linear algebra used by the public interface: aliases of Eigen's types, so that callers can
// use Eigen directly.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ovoid {

using Vec3 = Eigen::Vector3d;  // double precision: all transforms are double
using Mat3 = Eigen::Matrix3d;
using Affine3 = Eigen::Affine3d;  // named to_from: `world_from_index * index = world`
using Bounds3 = Eigen::AlignedBox3d;

}  // namespace ovoid
